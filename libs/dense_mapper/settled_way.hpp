#pragma once
// New surfaces cannot tell a robot that stands from one before which something goes ahead: in its view both
// stand still. So they may lead it away from where its wheels and the settled map lead it, but only as far as
// wheels slip.

#include <optional>

#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/registration/registration.hpp>

namespace lcmslam {

/// A second estimate beside the robot's pose, of x, y and heading: a Kalman filter that wheels predict and
/// pairs with settled surfaces correct.
class SettledWay {
 public:
  /// Pose and way are one, and the way is known.
  void begin() { *this = {}; }

  /// The robot has been led to `placed` from `T_expected`, where `motion` of its wheels has led it since the
  /// last call. Where the settled way leads instead, if that is too far from there for wheels that slip; the
  /// robot is there then. `anchored`: keyframes' features say so, too; then wheels may slip ten times as far.
  std::optional<Eigen::Isometry3d> observe(const Motion& motion, const Eigen::Isometry3d& T_expected,
                                           const RegistrationResult& placed, bool anchored = false);

 private:
  Eigen::Vector3d away_ = Eigen::Vector3d::Zero();  // of the way from the pose: x, y, heading, body frame
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();  // of the way, slipping wheels aside
};

}  // namespace lcmslam
