#pragma once
// A depth image prepared for registration while the camera's motion is not known yet: odometry comes later
// than the image, and preparing is most of the work.

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/imaging/thinned_depth.hpp>

namespace lcmslam {

/// At the depth image's time, rows as they were read.
using DepthView = ThinnedDepth;

/// Every step-th row's and column's points with normals and sigmas in the colour camera's frame, tile by
/// tile. `T_colour_depth_time` as for DepthRegistration; `row_motion`: the camera's twist from the first row
/// to the last (rolling_shutter.hpp), zero where all rows are of one moment. Normals follow the shear
/// that turning gives a surface.
Cloud cloud_of(const DepthView& view, const Eigen::Isometry3d& T_colour_depth_time,
               const Vector6d& row_motion);

}  // namespace lcmslam
