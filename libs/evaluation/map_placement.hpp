#pragma once
// Where a map lies in the truth's world, by the path that made it.

#include <vector>

#include <lcmslam/evaluation/trajectory_error.hpp>

namespace lcmslam {

/// Best motion of the estimate's world by all of its matched poses (one at least). The positions of a path
/// that is nearly straight leave open how the world is turned about it, and a map reaches metres to its side;
/// where they do, orientations tell. Both must be of one body.
Eigen::Isometry3d placed_by_poses(const std::vector<MatchedPose>& matches);

}  // namespace lcmslam
