#pragma once
#include <vector>

namespace lcmslam {

struct Command {
  const char* name;
  int (*run)(int argc, char** argv);  ///< argv begins with the command's name; argv[-1] is the program's
  const char* help = "";
  std::vector<Command> below = {};  ///< subcommands, each with options of its own
};

/// A main(): runs the command that the first argument names and gives the exit code; 2 for ConfigError, 1 for
/// other exceptions and output that could not be written. `help` lists the commands, `help COMMAND` is
/// `COMMAND --help`.
int run_commands(const std::vector<Command>& commands, int argc, char** argv);

/// The subcommand of `command` that argv[1] names; without one, or for one that is not there, its list and 2.
int run_subcommand(const char* command, const std::vector<Command>& subcommands, int argc, char** argv);

/// A command whose own program, `program`, lies beside this one and takes over. Does not come back; throws
/// std::runtime_error where the program is not there.
void hand_over(const char* program, char** argv);

}  // namespace lcmslam
