#pragma once
// The dense map as a log's messages have it, point by point with the time when it was seen.

#include <string>
#include <vector>

#include <lcmslam/evaluation/wall_error.hpp>

namespace lcmslam {

struct LoggedDenseMap {
  /// Points of keyframes that the mapper thinned out have joined another keyframe and carry its time: a visit
  /// of theirs may count as that one's.
  std::vector<SeenPoint> points;
  int refused = 0;  ///< messages of the map that could not be decoded or make no sense
};

/// The points of the newest mapper's keyframes, those of its last graph at its poses, moved by T: what a map
/// server shows at the log's end. Throws std::runtime_error when the log has no whole ICP_KEYFRAME of it.
LoggedDenseMap dense_map_of(const std::string& log, const Eigen::Isometry3d& T);

}  // namespace lcmslam
