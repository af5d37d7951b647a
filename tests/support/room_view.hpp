#pragma once
// What a robot sees of a scene.

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/geometry/random.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {

/// The scene in the robot's (= camera's) frame, slightly noisy.
inline ColouredCloud seen_from(const Cloud& scene, const Eigen::Isometry3d& T_world_robot,
                               std::uint64_t seed) {
  const Cloud moved = transformed(scene, T_world_robot.inverse());
  Random random(seed);
  ColouredCloud cloud;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    cloud.points.emplace_back(moved.points[i] +
                              static_cast<float>(random.normal(0, 0.003)) * moved.normals[i]);
    cloud.normals.push_back(moved.normals[i]);
    cloud.sigmas.push_back(0.003f);
    cloud.colours.emplace_back(10, 20, 30);
  }
  return cloud;
}

}  // namespace lcmslam
