#pragma once
// What each command is for, in one place for `help`, completion and the manual pages of all three programs.

#include <string>

namespace lcmslam {

/// One line; empty for a command that there is not.
const char* command_help(const std::string& command);

}  // namespace lcmslam
