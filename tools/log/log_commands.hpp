#pragma once
// The subcommands of `lcmslam log`.

#include "tools/commands.hpp"

namespace lcmslam {

const std::vector<Command>& log_subcommands();

int log_info_command(int argc, char** argv);
int log_check_command(int argc, char** argv);
int log_repair_command(int argc, char** argv);
int log_cut_command(int argc, char** argv);
int log_calibrate_command(int argc, char** argv);
int log_export_command(int argc, char** argv);
int log_play_command(int argc, char** argv);
int log_view_command(int argc, char** argv);

}  // namespace lcmslam
