#pragma once
// The subcommands of `lcmslam log`.

namespace lcmslam {

int log_info_command(int argc, char** argv);
int log_check_command(int argc, char** argv);
int log_repair_command(int argc, char** argv);
int log_cut_command(int argc, char** argv);
int log_play_command(int argc, char** argv);

}  // namespace lcmslam
