#pragma once
// A command of `lcmslam` as a user runs it, in this process: exit code and what it printed.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tools/run_commands.hpp"

namespace lcmslam::testing {

struct CommandRun {
  int exit_code = -1;
  std::string out, errors;

  /// Of the errors.
  std::string last_line() const {
    const std::size_t end = errors.find_last_not_of('\n');
    if (end == std::string::npos) return "";
    const std::size_t before = errors.rfind('\n', end);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    return errors.substr(begin, end + 1 - begin);
  }
};

inline CommandRun run_command(const Command& command, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"lcmslam", command.name});
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  CommandRun run;
  run.exit_code = run_commands({command}, static_cast<int>(argv.size()), argv.data());
  run.out = ::testing::internal::GetCapturedStdout();
  run.errors = ::testing::internal::GetCapturedStderr();
  return run;
}

}  // namespace lcmslam::testing
