#pragma once
// Odometry of another driver that publishes poses alone: what they are worth is assumed.

#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

class ExternalOdometry {
 public:
  /// The pose as the driver gives it, with the covariance S_b = Ad(T_b_a) S_a Ad(T_b_a)^T + Q (right
  /// perturbation). Q grows with the way driven and turned since the pose before (the first counts from
  /// the identity), alike on all six axes.
  /// A driver that begins anew (a step that no robot makes, or back at its origin after a silence) tells no
  /// motion: the pose stays, Q is all that may have been driven meanwhile (unknown_motion), and its way goes
  /// on from there (`restarts`).
  MotionSample update(Utime utime, const Eigen::Isometry3d& T_driver_robot);

  int restarts() const { return restarts_; }

 private:
  Eigen::Isometry3d T_odom_driver_ = Eigen::Isometry3d::Identity();  // as of the newest restart
  MotionSample sample_;
  int restarts_ = 0;
};

}  // namespace lcmslam
