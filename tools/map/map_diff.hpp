#pragma once
// What one map has and another has not, and how far what both have lies apart.

#include <lcmslam/map_store/file/map_file.hpp>

namespace lcmslam {

struct DiffCount {
  std::int64_t only_first = 0, only_second = 0, both = 0;
  double greatest_distance = 0;  ///< m, of what is in both
  double greatest_angle = 0;     ///< rad, of keyframes
  std::int64_t farthest = -1;    ///< id of what moved most

  bool same() const {
    return only_first == 0 && only_second == 0 && greatest_distance == 0 && greatest_angle == 0;
  }
};

/// Of the sessions of one name.
struct SessionDiff {
  std::string name;
  bool in_first = false, in_second = false;
  DiffCount keyframes, landmarks;

  bool same() const { return in_first && in_second && keyframes.same() && landmarks.same(); }
};

/// Sessions are compared by their names (names_of), keyframes and landmarks by their ids.
std::vector<SessionDiff> diff_maps(MapFile& first, MapFile& second);

}  // namespace lcmslam
