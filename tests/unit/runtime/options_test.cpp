#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/version.hpp>

#include <gmock/gmock.h>

#include <unistd.h>
#include <cstdlib>
#include <fstream>

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using ::testing::internal::CaptureStderr;
using ::testing::internal::CaptureStdout;
using ::testing::internal::GetCapturedStderr;
using ::testing::internal::GetCapturedStdout;

class Options : public ::testing::Test {
 protected:
  void SetUp() override {
    unsetenv("LCM_DEFAULT_URL");
    file_ = ::testing::TempDir() + std::to_string(getpid()) + "_options_test.yaml";
    write("surf: {octaves: 3}\nicp: {voxel_size: 0.1}\nlaunch: {restart: false}\n");
  }
  void TearDown() override { std::remove(file_.c_str()); }
  void write(const std::string& text) { std::ofstream(file_) << text; }

  bool parse(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "lcmslam-surf");
    std::vector<char*> argv;
    for (auto& argument : arguments) argv.push_back(argument.data());
    CaptureStdout();
    CaptureStderr();
    const bool go_on = parse_options(static_cast<int>(argv.size()), argv.data(), "surf", "Finds features.",
                                     options_, exit_code_);
    out_ = GetCapturedStdout();
    err_ = GetCapturedStderr();
    return go_on;
  }

  /// What a process says of this file and these overrides when it reads only `octaves`.
  std::string error_of_surf(const std::vector<std::string>& overrides = {}) {
    try {
      ProcessOptions options;
      options.config = file_;
      options.overrides = overrides;
      const ProcessConfig config = process_config(options, "surf");
      octaves_ = config.section.get("octaves", 4, Range{1, 6});
      config.file.finish();
      return {};
    } catch (const ConfigError& error) {
      return error.what();
    }
  }

  std::string file_, out_, err_;
  ProcessOptions options_;
  int exit_code_ = -1;
  int octaves_ = 0;
};

TEST_F(Options, HelpAndVersionEndWithoutError) {
  EXPECT_FALSE(parse({"--help"}));
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(out_, ::testing::AllOf(HasSubstr("Finds features."), HasSubstr("--config"), HasSubstr("--set"),
                                     HasSubstr("--lcm-url"), HasSubstr("--log-level")));
  EXPECT_FALSE(parse({"--version"}));
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(out_, HasSubstr(lcmslam_version));
}

TEST_F(Options, WrongOptionsEndWithTwoAndAReason) {
  for (const std::vector<std::string>& wrong :
       std::vector<std::vector<std::string>>{{"--colour"},
                                             {"surplus"},
                                             {"--config", "/no/such/file.yaml"},
                                             {"--log-level", "loud"},
                                             {"--config"}}) {
    exit_code_ = -1;
    EXPECT_FALSE(parse(wrong));
    EXPECT_EQ(exit_code_, 2) << wrong[0];
    EXPECT_THAT(err_, HasSubstr(wrong.size() > 1 ? wrong[1] : wrong[0]));
  }
}

TEST_F(Options, AreTakenFromTheCommandLine) {
  ASSERT_TRUE(parse({"--config", file_, "--lcm-url", "memq://", "--log-level", "warn", "--set",
                     "surf.octaves=2", "--set", "surf.upright=true"}));
  EXPECT_EQ(options_.config, file_);
  EXPECT_EQ(options_.lcm_url, "memq://");
  EXPECT_EQ(options_.log_level, "warn");
  EXPECT_THAT(options_.overrides, ::testing::ElementsAre("surf.octaves=2", "surf.upright=true"));
}

TEST_F(Options, UrlComesFromTheEnvironmentAndElseStaysOnThisMachine) {
  ASSERT_TRUE(parse({}));
  EXPECT_EQ(options_.lcm_url, default_lcm_url);
  EXPECT_THAT(options_.lcm_url, HasSubstr("ttl=0"));
  setenv("LCM_DEFAULT_URL", "udpm://239.1.2.3:4567?ttl=0", 1);
  ProcessOptions fresh;
  options_ = fresh;
  ASSERT_TRUE(parse({}));
  EXPECT_EQ(options_.lcm_url, "udpm://239.1.2.3:4567?ttl=0");
  unsetenv("LCM_DEFAULT_URL");
}

TEST_F(Options, SetOverridesTheFile) {
  EXPECT_EQ(error_of_surf(), "");
  EXPECT_EQ(octaves_, 3);
  EXPECT_EQ(error_of_surf({"surf.octaves=5"}), "");
  EXPECT_EQ(octaves_, 5);
  EXPECT_THAT(error_of_surf({"surf.octaves=50"}), HasSubstr("octaves"));
  EXPECT_THAT(error_of_surf({"surf.octaves"}), HasSubstr("section.key=value"));
  EXPECT_THAT(error_of_surf({"=5"}), HasSubstr("section.key=value"));
}

TEST_F(Options, UnknownKeyOfTheOwnSectionIsAnErrorThatNamesIt) {
  write("surf: {octave: 3}\n");
  EXPECT_THAT(error_of_surf(), ::testing::AllOf(HasSubstr("octave"), HasSubstr("options_test.yaml")));
  EXPECT_THAT(error_of_surf({"surf.octave=1"}), HasSubstr("octave"));
}

TEST_F(Options, SectionsOfOtherProcessesAreTheirs) {
  for (const std::string& process : process_names()) {
    if (process == "surf") continue;
    write("surf: {octaves: 3}\n" + process + ": {nobody: knows}\n");
    EXPECT_EQ(error_of_surf(), "") << process;
  }
}

TEST_F(Options, SectionOfNoProcessIsAnError) {
  write("surff: {octaves: 3}\n");
  EXPECT_THAT(error_of_surf(), HasSubstr("surff"));
}

}  // namespace
}  // namespace lcmslam
