#pragma once
// The dense map as a log's messages have it, point by point with the time when it was seen.

#include <string>
#include <vector>

#include "evaluation/wall_error.hpp"

namespace lcmslam {

/// The points of all keyframes at their last poses, moved by T. Throws std::runtime_error when the log has
/// no ICP_KEYFRAME.
std::vector<SeenPoint> dense_map_of(const std::string& log, const Eigen::Isometry3d& T);

}  // namespace lcmslam
