#include "tools/calibrate/calibrate_commands.hpp"
#include "tools/commands.hpp"

namespace lcmslam {

const std::vector<Command>& calibrate_subcommands() {
  static const std::vector<Command> subcommands = {
      {"board", calibrate_board_command, "prints the board that the others look for"},
  };
  return subcommands;
}

int calibrate_command(int argc, char** argv) {
  return run_subcommand("calibrate", calibrate_subcommands(), argc, argv);
}

}  // namespace lcmslam
