#include "tools/run_commands.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <set>
#include <sstream>

#include <lcmslam/configuration/config.hpp>
#include "tests/support/source_folder.hpp"
#include "tools/command_help.hpp"
#include "tools/commands.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Output {
  int exit_code;
  std::string out, error;
};

Output run(std::vector<std::string> words) {
  words.insert(words.begin(), "lcmslam");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  const int exit_code = run_commands(commands(), static_cast<int>(words.size()), argv.data());
  const std::string out = ::testing::internal::GetCapturedStdout();
  return {exit_code, out, ::testing::internal::GetCapturedStderr()};
}

TEST(RunCommands, HelpListsEveryCommandWithItsPurpose) {
  for (const char* word : {"help", "--help", "-h"}) {
    const Output output = run({word});
    EXPECT_EQ(output.exit_code, 0);
    EXPECT_EQ(output.error, "");
    for (const Command& command : commands()) {
      EXPECT_THAT(output.out, HasSubstr(std::string("  ") + command.name + " "));
      EXPECT_THAT(output.out, HasSubstr(command_help(command.name)));
    }
  }
}

TEST(RunCommands, HelpOfACommandIsItsOwn) {
  const Output output = run({"help", "log", "cut"});
  EXPECT_EQ(output.exit_code, 0);
  EXPECT_EQ(output.out, run({"log", "cut", "--help"}).out);
  EXPECT_THAT(output.out, HasSubstr("--channels"));
  EXPECT_EQ(run({"help", "log"}).out, run({"log", "--help"}).out);
}

TEST(RunCommands,
     ACommandFindsTheProgramsNameBeforeItsOwn) {  // those that hand over start again with the whole line
  static std::string line;
  const auto remember = [](int argc, char** argv) {
    line = argv[-1];
    for (int i = 0; i < argc; ++i) line += std::string(" ") + argv[i];
    return 7;
  };
  char program[] = "bin/lcmslam", help[] = "help", name[] = "part", option[] = "--fast";
  char* plain[] = {program, name, option, nullptr};
  EXPECT_EQ(run_commands({{"part", remember}}, 3, plain), 7);
  EXPECT_EQ(line, "bin/lcmslam part --fast");
  char* asked[] = {program, help, name, nullptr};
  EXPECT_EQ(run_commands({{"part", remember}}, 3, asked), 7);
  EXPECT_EQ(line, "bin/lcmslam part --help");
}

// A service does not start again what ends with 2.
TEST(RunCommands, AWrongConfigurationIsTwoAndAnyOtherFailureOne) {
  const auto wrong = [](int, char**) -> int { throw ConfigError("robot.yaml:3: unknown key"); };
  const auto failed = [](int, char**) -> int { throw std::runtime_error("the disk is full"); };
  char program[] = "lcmslam", name[] = "part";
  char* line[] = {program, name, nullptr};
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run_commands({{"part", wrong}}, 2, line), 2);
  EXPECT_EQ(run_commands({{"part", failed}}, 2, line), 1);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(),
            "lcmslam part: robot.yaml:3: unknown key\nlcmslam part: the disk is full\n");
}

TEST(RunCommands, WithoutACommandSaysWhatThereIs) {
  const Output output = run({});
  EXPECT_EQ(output.exit_code, 2);
  EXPECT_THAT(output.error, StartsWith("usage: lcmslam COMMAND"));
}

// ./lcmslam builds before it hands over, so that it has to know the names.
TEST(LcmslamScript, HandsOverEveryCommand) {
  std::ifstream script(source_folder() / "lcmslam");
  std::set<std::string> known;
  for (std::string line; std::getline(script, line);) {
    if (line.empty() || line.compare(0, 2, "  ") != 0 || line.find(')') == std::string::npos) continue;
    std::istringstream names(line.substr(0, line.find(')')));
    for (std::string name; names >> name;) known.insert(name);
  }
  for (const Command& command : commands()) EXPECT_EQ(known.count(command.name), 1U) << command.name;
}

}  // namespace
}  // namespace lcmslam
