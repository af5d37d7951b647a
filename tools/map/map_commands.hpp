#pragma once
// The subcommands of `lcmslam map`.

#include "tools/commands.hpp"

namespace lcmslam {

const std::vector<Command>& map_subcommands();

int map_info_command(int argc, char** argv);
int map_export_command(int argc, char** argv);
int map_view_command(int argc, char** argv);
int map_merge_command(int argc, char** argv);
int map_compact_command(int argc, char** argv);
int map_verify_command(int argc, char** argv);
int map_diff_command(int argc, char** argv);

}  // namespace lcmslam
