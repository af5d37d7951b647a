#pragma once
// The subcommands of `lcmslam`; each parses its own options and gives the exit code.

namespace lcmslam {

int demo_command(int argc, char** argv);
int import_command(int argc, char** argv);
int launch_command(int argc, char** argv);
int simulate_command(int argc, char** argv);
int study_command(int argc, char** argv);

}  // namespace lcmslam
