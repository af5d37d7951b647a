#include "tools/commands.hpp"
#include "tools/map/map_commands.hpp"

namespace lcmslam {

const std::vector<Command>& map_subcommands() {
  static const std::vector<Command> subcommands = {
      {"info", map_info_command, "what is in a map file: sessions, keyframes, landmarks, versions"},
      {"export", map_export_command,
       "files that others read: PLY, PCD, CSV, mesh, OctoMap, PGM, trajectories"},
      {"view", map_view_command, "in a browser, or pictures of what is in it"},
      {"merge", map_merge_command, "two maps of one place in one file"},
      {"compact", map_compact_command, "gives the room of what is gone back to the disk"},
      {"verify", map_verify_command, "is a map in it, and all of it whole? Exit code 0 only then"},
      {"diff", map_diff_command,
       "which keyframes and landmarks one map has and another has not, and how far they moved"}};
  return subcommands;
}

int map_command(int argc, char** argv) {
  return run_subcommand("map", map_subcommands(), argc, argv);
}

}  // namespace lcmslam
