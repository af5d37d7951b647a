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

/// Of one session.
struct SessionDiff {
  std::string name;                     ///< in the first file, else in the second
  std::string first_name, second_name;  ///< empty: that file has it not
  DiffCount keyframes, landmarks;

  bool in_first() const { return !first_name.empty(); }
  bool in_second() const { return !second_name.empty(); }
  bool in_both() const { return in_first() && in_second(); }
  bool same() const { return in_both() && keyframes.same() && landmarks.same(); }
};

struct CommonSession {
  std::string name;  ///< in the first file
  std::int64_t id_in_first = 0, id_in_second = 0;
};
/// By their ids in the first.
std::vector<CommonSession> common_sessions(MapFile& first, MapFile& second);

/// A session is known again by the process that made it; its keyframes and landmarks by their ids, which in
/// another run's session are others' places.
std::vector<SessionDiff> diff_maps(MapFile& first, MapFile& second);

}  // namespace lcmslam
