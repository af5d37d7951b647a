#pragma once
// Places features by a depth image that was moved in time: a camera that turns at 100 degrees/s sees another
// place 14 ms later, 14 pixels beside, and a feature's depth must be read where the feature was then.

#include <lcmslam/features/feature.hpp>
#include <lcmslam/imaging/thinned_depth.hpp>

namespace lcmslam {

/// The same features with points and sigmas from `depth`; `point` features without depth there, or at an edge
/// of it, become `bearing`. `T_depth_colour`: from the colour camera at the colour image's time to the depth
/// camera at the depth image's time. `T_colour_points`: from the frame of `depth.points` to the colour camera
/// at the colour image's time; identity where they stand there already.
FeatureFrame placed_by(const RegisteredDepth& depth, const CameraModel& depth_camera,
                       const Eigen::Isometry3d& T_depth_colour, FeatureFrame features,
                       const Eigen::Isometry3d& T_colour_points = Eigen::Isometry3d::Identity());

/// The same by all points of `frame`, of which only those around the features are made.
FeatureFrame placed_by(const DepthPoints& depth, const RgbdFrame& frame,
                       const Eigen::Isometry3d& T_depth_colour, FeatureFrame features,
                       const Eigen::Isometry3d& T_colour_points);

}  // namespace lcmslam
