#pragma once
// One moment as the dense mapper takes it: everything stands at the same time, in the colour camera's frame.

#include <functional>
#include <optional>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/features/feature.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/rgbd/colour_view.hpp>

namespace lcmslam {

/// Makes the coloured cloud of a frame. Few frames become keyframes, so only theirs is made.
using Colouriser = std::function<ColouredCloud()>;

struct DenseFrame {
  Utime utime = 0;
  Cloud cloud;            ///< with normals; with intensities where the registration compares colours
  double noise_left = 1;  ///< share of the cloud's sigmas that smoothing has left (DepthFilter::noise_left)
  Colouriser colouriser;
  Eigen::Isometry3d T_robot_camera = Eigen::Isometry3d::Identity();
  std::optional<Motion> motion;          ///< the robot's since the frame before, where odometry knows it
  std::optional<FeatureFrame> features;  ///< where they are there already
  std::optional<ColourView> colour;      ///< for registrations that compare images
};

/// A frame whose colours are there already.
DenseFrame coloured_frame(Utime utime, const ColouredCloud& cloud, const Eigen::Isometry3d& T_robot_camera,
                          const std::optional<Motion>& motion = std::nullopt);

}  // namespace lcmslam
