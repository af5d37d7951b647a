#include <fmt/format.h>
#include <iostream>

#include <lcmslam/map_store/file/check_map_file.hpp>
#include <lcmslam/map_store/file/compact_map_file.hpp>
#include "tools/map/map_commands.hpp"
#include "tools/output_file.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {

int map_verify_command(int argc, char** argv) {
  std::string file;
  CLI::App app{
      "Looks at every page, reference and row of a map file. Exit code 0 only when it holds a map and all of "
      "it is whole.",
      "lcmslam map verify"};
  app.add_option("file", file, "an .lcmslam file")->required();
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  const MapFileCheck check = check_map_file(file);
  for (const std::string& fault : check.faults) std::cout << "  " << fault << "\n";
  if (check.faults.size() == MapFileCheck::most_faults) std::cout << "  and perhaps more\n";
  if (check.loose_edges > 0)
    std::cout << fmt::format("  {} edges lead to keyframes that are not there (messages were missed)\n",
                             check.loose_edges);
  // SQLite takes a file of no bytes for a database: a map that a disk lost would be whole.
  if (check.faults.empty() && check.sessions == 0) {
    std::cout << fmt::format("{}: holds NO MAP: nothing has been written into it\n", file);
    return 1;
  }
  std::cout << fmt::format(
      "{}: {}: {} sessions, {} nodes ({} keyframes with a cloud), features of {}, images of {}, {} edges, {} "
      "landmarks, "
      "{} poses\n",
      file, check.faults.empty() ? "whole" : "DAMAGED", check.sessions, check.keyframes, check.clouds,
      check.features, check.images, check.edges, check.landmarks, check.poses);
  return check.faults.empty() ? 0 : 1;
}

int map_compact_command(int argc, char** argv) {
  std::string file, out;
  bool force = false;
  CLI::App app{
      "Writes a map file anew without the room of what is gone; in its place, when nobody else has it open.",
      "lcmslam map compact"};
  app.add_option("file", file, "an .lcmslam file")->required();
  app.add_option("--out", out, "FILE: writes this one instead")->type_name("FILE");
  app.add_flag("--force", force, "overwrite that if it exists");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  const auto before =
      static_cast<double>(std::filesystem::exists(file) ? std::filesystem::file_size(file) : 0);
  if (out.empty()) {
    compact_map_file(file);
    out = file;
  } else {
    check_output_file(out, force);
    copy_compacted(file, FilePlace(out));
  }
  std::cout << fmt::format("{}: {:.1f} MB, was {:.1f} MB\n", out,
                           1e-6 * static_cast<double>(std::filesystem::file_size(out)), 1e-6 * before);
  return 0;
}

}  // namespace lcmslam
