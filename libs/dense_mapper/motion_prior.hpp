#pragma once
// What the mapper knows before it looks: odometry, or that the robot keeps its velocity, and, for
// wheeled robots, that it stays on the floor.

#include <optional>

#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/registration/solver.hpp>

namespace lcmslam {

struct MotionPriorSettings {
  bool planar = false;  ///< the robot drives on the plane z = 0 of the world
  // Added (squared) to odometry's own covariance: wheels slip by more than they state.
  double floor_translation = 0.03;  ///< m a step
  double floor_rotation = 0.03;     ///< rad a step
  // Without odometry: how far a step may differ from constant velocity.
  double free_translation = 0.04;  ///< m a step
  double free_rotation = 0.06;     ///< rad a step
  // With `planar`: how well the floor is a plane.
  double plane_height = 0.01;  ///< m
  double plane_tilt = 0.004;   ///< rad
};

/// Prior of T_world_robot from the last pose and the motion since: odometry's, or with a velocity
/// (twist of the last step) when there is none.
Prior predict(const Eigen::Isometry3d& T_world_last, const std::optional<Motion>& motion,
              const Eigen::Isometry3d& free_motion, const MotionPriorSettings& settings);

/// The same pose with no height, roll and pitch.
Eigen::Isometry3d on_floor(const Eigen::Isometry3d& T_world_robot);

}  // namespace lcmslam
