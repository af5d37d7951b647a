#pragma once
// What no measurement of the robot's cameras tells: that the head sits on the robot a little elsewhere than
// the calibration says. The cameras' path is as it is, and the robot's, seen from its first pose, is off by
//
//   xi = (1 - Ad(T_first_robot^-1)) Ad(T_robot_camera) m        T_true = T exp(xi), m: of T_robot_camera,
//   camera frame
//
// which is nothing where the robot began and most where it looks the other way.

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct MountErrorSettings {
  double translation_sigma = 0.002;
  double rotation_sigma = 0.001;

  void describe(SettingsVisitor& s) {
    s.number("translation_sigma", translation_sigma, "m", {0, 1},
             "of where the calibration says the head sits");
    s.number("rotation_sigma", rotation_sigma, "rad", {0, 1}, "the same");
  }
};

/// Of T_first_robot, body frame (m, rad); zero for a camera that is where the robot is: hand-held.
Matrix6d mount_error(const Eigen::Isometry3d& T_first_robot, const Eigen::Isometry3d& T_robot_camera,
                     const MountErrorSettings& settings);

}  // namespace lcmslam
