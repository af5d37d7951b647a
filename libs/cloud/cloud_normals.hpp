#pragma once
// Normals of clouds that come without.

#include <lcmslam/cloud/cloud.hpp>

namespace lcmslam {

/// Sets each point's normal to the direction of least spread of its `neighbours` nearest points,
/// turned towards the view point (m, the cloud's frame); NaN where the neighbours are fewer than
/// three or lie on a line.
void estimate_normals(Cloud& cloud, const Eigen::Vector3d& view_point, int neighbours = 12);

}  // namespace lcmslam
