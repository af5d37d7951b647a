#pragma once
// What the mapper knows before it looks: odometry, or that the robot keeps its velocity, and, for
// wheeled robots, that it stays on the floor.

#include <optional>

#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/registration/solver.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct MotionPriorSettings {
  bool planar = false;  ///< the robot drives on the plane z = 0 of the world; no key: the calibration tells
  double floor_translation = 0.03;
  double floor_rotation = 0.03;
  double free_translation = 0.04;
  double free_rotation = 0.06;
  double plane_height = 0.01;
  double plane_tilt = 0.004;

  void describe(SettingsVisitor& s) {
    s.number("floor_translation", floor_translation, "m", {0, 1000},
             "noise floor of a step, added (squared) to odometry's covariance: wheels slip by more than they "
             "state");
    s.number("floor_rotation", floor_rotation, "rad", {0, 3.1416},
             "noise floor of a step, added (squared) to odometry's covariance");
    s.number("free_translation", free_translation, "m", {0, 1000},
             "how far a step without odometry may differ from constant velocity");
    s.number("free_rotation", free_rotation, "rad", {0, 3.1416},
             "how far a step without odometry may differ from constant velocity");
    s.number("plane_height", plane_height, "m", {1e-6, 1000},
             "standard deviation of the ground's height under a robot that drives");
    s.number("plane_tilt", plane_tilt, "rad", {1e-6, 3.1416},
             "standard deviation of the ground's tilt under a robot that drives");
  }
};

/// Prior of T_world_robot from the last pose and the motion since: odometry's, or with a velocity
/// (twist of the last step) when there is none.
Prior predict(const Eigen::Isometry3d& T_world_last, const std::optional<Motion>& motion,
              const Eigen::Isometry3d& free_motion, const MotionPriorSettings& settings);

/// The same pose with no height, roll and pitch.
Eigen::Isometry3d on_floor(const Eigen::Isometry3d& T_world_robot);

}  // namespace lcmslam
