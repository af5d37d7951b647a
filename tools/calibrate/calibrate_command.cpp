#include "tools/calibrate/calibrate_commands.hpp"
#include "tools/commands.hpp"

namespace lcmslam {

const std::vector<Command>& calibrate_subcommands() {
  static const std::vector<Command> subcommands = {
      {"self", calibrate_self_command, "a camera head from any recording, without a board"},
  };
  return subcommands;
}

int calibrate_command(int argc, char** argv) {
  return run_subcommand("calibrate", calibrate_subcommands(), argc, argv);
}

}  // namespace lcmslam
