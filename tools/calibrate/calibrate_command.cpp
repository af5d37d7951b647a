#include "tools/calibrate/calibrate_commands.hpp"
#include "tools/commands.hpp"

namespace lcmslam {

const std::vector<Command>& calibrate_subcommands() {
  static const std::vector<Command> subcommands = {
      {"board", calibrate_board_command, "prints the board that camera, tof and pair look for"},
      {"camera", calibrate_camera_command, "intrinsics and distortion, from views of a board"},
      {"tof", calibrate_tof_command, "a time-of-flight camera: intrinsics, offset and wiggle of its ranges"},
      {"pair", calibrate_pair_command, "how colour and depth camera sit on each other"},
      {"mount", calibrate_mount_command, "where the camera sits on the robot, from a drive"},
      {"wheels", calibrate_wheels_command, "radii and track, from a drive"},
      {"self", calibrate_self_command, "a camera head from any recording, without a board"},
  };
  return subcommands;
}

int calibrate_command(int argc, char** argv) {
  return run_subcommand("calibrate", calibrate_subcommands(), argc, argv);
}

}  // namespace lcmslam
