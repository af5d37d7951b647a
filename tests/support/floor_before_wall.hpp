#pragma once
// What a robot's depth camera sees that looks down by some 20 degrees: a bare floor up to a wall.

#include <lcmslam/imaging/depth_error.hpp>
#include "tests/support/board_shots.hpp"

namespace lcmslam::testing {

/// T_robot_camera, about 1.3 m high.
inline Eigen::Isometry3d drawn_mount(Random& random) {
  const auto draw = [&](double by) { return random.uniform(-by, by); };
  Eigen::Isometry3d mount = Eigen::Isometry3d::Identity();
  mount.translation() << 0.1 + draw(0.1), draw(0.1), 1.3 + draw(0.2);
  mount.rotate(Eigen::AngleAxisd(draw(0.1), Eigen::Vector3d::UnitZ()));
  mount.rotate(Eigen::AngleAxisd(0.35 + draw(0.1), Eigen::Vector3d::UnitY()));
  return mount * optical_axes();
}

/// Depth (mm) of a floor and a wall 4 m before the camera's axis, while the robot nods a little; with what
/// the head's ranges err by.
inline cv::Mat floor_before_wall(const RgbdTruth& truth, const Eigen::Isometry3d& mount, Random& random) {
  const RgbdCalibration& c = truth.calibration;
  cv::Mat depth(c.depth.height, c.depth.width, CV_16UC1);
  const Eigen::Isometry3d T_floor_robot(
      Eigen::Quaterniond(so3_exp({random.normal(0, 0.0005), random.normal(0, 0.0005), 0})));
  const Eigen::Isometry3d T = T_floor_robot * mount * c.T_colour_depth;
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const Eigen::Vector3d ray = c.depth.ray({u, v}), d = T.linear() * ray;
      const double to_floor = -T.translation().z() / d.z();
      const bool floor = d.z() < 0 && to_floor < 4;
      const double z = floor ? to_floor : 4, range = z * ray.norm();
      const double cosine = floor ? -d.z() / ray.norm() : 1 / ray.norm();
      const double sigma = truth.noise * range * range / std::sqrt(0.5 * std::max(0.05, cosine));
      const double measured = range + c.depth_error.at(range) + random.normal(0, sigma);
      depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(1000 * measured / ray.norm() + 0.5);
    }
  return depth;
}

}  // namespace lcmslam::testing
