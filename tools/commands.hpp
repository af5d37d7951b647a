#pragma once
// The subcommands of `lcmslam`; each parses its own options and gives the exit code.

#include <vector>

#include "tools/run_commands.hpp"

namespace lcmslam {

/// All of them.
const std::vector<Command>& commands();

int batch_command(int argc, char** argv);
int calibrate_command(int argc, char** argv);
int collect_command(int argc, char** argv);
int completion_command(int argc, char** argv);
int config_command(int argc, char** argv);
int demo_command(int argc, char** argv);
int doctor_command(int argc, char** argv);
int evaluate_command(int argc, char** argv);
int export_command(int argc, char** argv);
int echo_command(int argc, char** argv);
int import_command(int argc, char** argv);
int launch_command(int argc, char** argv);
int lcm_spy_command(int argc, char** argv);
int log_command(int argc, char** argv);
int map_command(int argc, char** argv);
int query_command(int argc, char** argv);
int render_command(int argc, char** argv);
int send_command(int argc, char** argv);
int simulate_command(int argc, char** argv);
int spy_command(int argc, char** argv);
int study_command(int argc, char** argv);

}  // namespace lcmslam
