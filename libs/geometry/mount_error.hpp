#pragma once
// What no measurement of the robot's cameras tells: that the head sits on the robot a little elsewhere than
// the calibration says, at T_robot_camera exp(m). Seen from the first camera, the cameras' path is as it is,
// and the robot's, seen from its first pose, is off by
//
//   xi = Ad(T_robot_camera) (x - L m),   L = 1 - Ad(T_first_now^-1)          T_true = T exp(xi); m, x: camera
//   frame
//
// with T_first_now from the first camera to this one: nothing where the robot began and most where it looks
// the other way. x is by how much m moves the camera's own pose: a robot that is said to stand on a floor is
// held there with the wrong mount, A x = A L m for height, roll and pitch A (the pose graph's), so that of
// these it errs by little.

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

  /// Of m; zero for a camera that is where the robot is: hand-held.
  Vector6d sigmas(const Eigen::Isometry3d& T_robot_camera) const;
};

/// L.
Matrix6d mount_lever(const Eigen::Isometry3d& T_first_now);

/// Of xi: m, rad, robot's body frame. `moved`: x for one sigma of each part of m.
Matrix6d mount_error(const Eigen::Isometry3d& T_first_now, const Eigen::Isometry3d& T_robot_camera,
                     const Vector6d& sigmas, const Matrix6d& moved);

}  // namespace lcmslam
