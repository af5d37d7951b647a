#pragma once
// Is everything in a map file whole?

#include <filesystem>
#include <string>
#include <vector>

namespace lcmslam {

struct MapFileCheck {
  std::vector<std::string> faults;  ///< in words, at most `most_faults`; none: all is whole
  std::int64_t sessions = 0, keyframes = 0, clouds = 0, features = 0, images = 0, edges = 0, landmarks = 0,
               poses = 0;
  std::int64_t loose_edges = 0;  ///< to keyframes that are not there: messages of the graph were missed

  static constexpr std::size_t most_faults = 20;
};

/// SQLite's own check of every page and index, references between the tables, and each blob's checksum and
/// content. Throws StoreError for a file that cannot be opened or is no map.
MapFileCheck check_map_file(const std::filesystem::path& file);

}  // namespace lcmslam
