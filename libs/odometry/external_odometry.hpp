#pragma once
// Odometry of another driver that publishes poses alone: what they are worth is assumed.

#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

class ExternalOdometry {
 public:
  /// The pose as the driver gives it, with the covariance S_b = Ad(T_b_a) S_a Ad(T_b_a)^T + Q (right
  /// perturbation). Q grows with the way driven and turned since the pose before (the first counts from
  /// the identity), alike on all six axes.
  MotionSample update(Utime utime, const Eigen::Isometry3d& T_odom_robot);

 private:
  MotionSample sample_;
};

}  // namespace lcmslam
