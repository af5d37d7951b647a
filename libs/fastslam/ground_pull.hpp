#pragma once
// What the floor says of a pose in space: a measurement of height, roll and pitch (each 0) that all particles
// take alike, before they look. So a robot that has left the plane is held again by what it stands on, and
// all six degrees stay free.

#include <Eigen/Dense>

#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/geometry/ground_plane.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

class GroundPull {
 public:
  /// Kalman gain of a pose with this covariance (right perturbation).
  GroundPull(const GroundContact& ground, const Matrix6d& covariance) {
    Eigen::Matrix3d S = covariance.block<3, 3>(2, 2);
    S.diagonal() += ground.sigmas().cwiseAbs2();
    gain_ = S.ldlt().solve(covariance.middleRows<3>(2)).transpose();
  }

  Eigen::Isometry3d operator()(const Eigen::Isometry3d& T_world_robot) const {
    return T_world_robot * se3_exp(-gain_ * off_ground(T_world_robot));
  }
  Matrix6d reduced(const Matrix6d& covariance) const {
    const Matrix6d left = covariance - gain_ * covariance.middleRows<3>(2);
    return 0.5 * (left + left.transpose());
  }

 private:
  Eigen::Matrix<double, 6, 3> gain_;
};

}  // namespace lcmslam
