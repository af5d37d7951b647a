#pragma once
// The subcommands of `lcmslam calibrate`.

#include "tools/commands.hpp"

namespace lcmslam {

const std::vector<Command>& calibrate_subcommands();

int calibrate_board_command(int argc, char** argv);
int calibrate_camera_command(int argc, char** argv);
int calibrate_tof_command(int argc, char** argv);
int calibrate_pair_command(int argc, char** argv);
int calibrate_mount_command(int argc, char** argv);
int calibrate_wheels_command(int argc, char** argv);
int calibrate_self_command(int argc, char** argv);

}  // namespace lcmslam
