// The command lines of all programs.

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"

namespace lcmslam::integration {
namespace {

using testing::HasSubstr;

constexpr double patience = 30;  // s

std::vector<std::vector<std::string>> all_programs() {
  return {{"lcmslam"},           {"lcmslam", "demo"},     {"lcmslam", "launch"},
          {"lcmslam", "import"}, {"lcmslam", "simulate"}, {"lcmslam", "study"},
          {"lcmslam-camera"},    {"lcmslam-surf"},        {"lcmslam-odometry"},
          {"lcmslam-fastslam"},  {"lcmslam-icp"},         {"lcmslam-map-server"}};
}

class Options : public testing::TestWithParam<std::vector<std::string>> {
 protected:
  static Result run_with(const std::string& option, const std::vector<std::string>& before = {}) {
    std::vector<std::string> arguments = GetParam();
    arguments.insert(arguments.end(), before.begin(), before.end());
    arguments.push_back(option);
    return run(arguments, patience);
  }

  /// Without them their absence is what a command complains of.
  static std::vector<std::string> required_arguments() {
    const std::string command = GetParam().back();
    if (command == "launch") return {source_folder() / "config/demo.yaml"};
    if (command == "import") return {source_folder(), "/tmp/never-written.lcmlog"};
    if (command == "simulate")
      return {source_folder() / "config/scenes/kitchen.yaml", "/tmp/never-written.lcmlog"};
    return {};
  }
};

TEST(Demo, WithoutABusLeavesNoFolder) {
  const TemporaryFolder folder;
  const Result result =
      run({"lcmslam", "demo", "--headless", "--lcm-url", "udpm://10.0.0.1:7667", "--out", folder / "demo"},
          patience);
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_FALSE(std::filesystem::exists(folder / "demo")) << result.output;
}

TEST_P(Options, HelpNamesTheProgramAndSucceeds) {
  const Result result = run_with("--help");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr(GetParam().front()));
}

TEST_P(Options, VersionSucceeds) {
  const Result result = run_with("--version");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, testing::ContainsRegex("lcmslam [0-9]+\\.[0-9]+\\.[0-9]+"));
}

TEST_P(Options, AnUnknownOptionIsNamedAndRefused) {
  const Result result = run_with("--no-such-option", required_arguments());
  EXPECT_EQ(result.exit_code, 2) << result.output;
  EXPECT_THAT(result.output, HasSubstr("--no-such-option"));
}

INSTANTIATE_TEST_SUITE_P(AllPrograms, Options, testing::ValuesIn(all_programs()), [](const auto& instance) {
  std::string name = instance.param.front() + (instance.param.size() > 1 ? "_" + instance.param[1] : "");
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST(OptionsOfLcmslam, AnUnknownCommandIsRefused) {
  const Result result = run({"lcmslam", "dance"}, patience);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("dance"));
}

TEST(OptionsOfLcmslam, OutputThatCannotBeWrittenIsAnError) {
  const std::string lcmslam = find_program("lcmslam");
  const Result full = run({"/bin/sh", "-c", lcmslam + " log --help > /dev/full"}, patience);
  EXPECT_EQ(full.exit_code, 1);
  EXPECT_THAT(full.output, HasSubstr("standard output"));
  const Result fine = run({"/bin/sh", "-c", lcmslam + " log --help > /dev/null"}, patience);
  EXPECT_EQ(fine.exit_code, 0);
}

TEST(OptionsOfProcesses, AFileThatIsMissingIsNamed) {
  for (const std::string option : {"--config", "--log-level"}) {
    const Result result = run({"lcmslam-surf", option, "/nowhere/at-all"}, patience);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.output, HasSubstr("/nowhere/at-all"));
  }
}

}  // namespace
}  // namespace lcmslam::integration
