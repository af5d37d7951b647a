#pragma once
// The robot's motion as its camera makes it.

#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

/// T_camera_from_to: x_from = T x_to, camera frames.
inline Eigen::Isometry3d camera_motion(const Motion& motion, const Eigen::Isometry3d& T_robot_camera) {
  return T_robot_camera.inverse() * motion.T_from_to * T_robot_camera;
}

}  // namespace lcmslam
