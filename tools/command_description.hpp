#pragma once
// A command's whole description, for its manual page.

#include "tools/parse_command.hpp"

namespace lcmslam {

struct PositionalDescription {
  std::string name;
  bool required = false;
  bool many = false;
  bool named = false;  ///< there is an option of that name, too
};

struct CommandDescription {
  std::string text;
  std::string footer;
  std::vector<OptionDescription> options;  ///< positional ones too
  std::vector<PositionalDescription> positionals;
};

/// The command does not run: it ends where it would parse.
CommandDescription describe_whole_command(int (*command)(int, char**));

}  // namespace lcmslam
