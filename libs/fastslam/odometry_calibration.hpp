#pragma once
// Systematic errors of the odometry, learned while driving. Wheels of unequal radius, a steering offset or
// a wrong scale make errors that go the same way for minutes; taken for white noise they make a filter
// overconfident (Victoria Park: heading turns by 1.4 mrad a metre, a random walk of the stated noise would
// give a tenth of that over a lap). The calibration c is a linear Gaussian part of each particle's state:
//
//   motion(c) = exp(xi + J(xi) c),   xi = log of the measured motion,   c = (scale of the way, scale of the
//   heading, heading per metre),   c a random walk over the way driven
//
// Given the particle's path it has a closed form (Rao-Blackwell): each step's drawn motion is a measurement
// of c. J depends on the odometry alone, so that all particles share the covariance and differ in the mean.

#include <lcmslam/fastslam/pose_space.hpp>
#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

using CalibrationMean = Eigen::Vector3d;

class OdometryCalibration {
 public:
  explicit OdometryCalibration(const FastSlamSettings& settings);

  /// Begins a step; the motion is the odometry's. Without a motion (or a visual one) nothing is learned.
  void begin(const Motion& odometry);

  /// Off in settings, or nothing to learn in this step.
  bool active() const { return active_; }

  /// The motion as a particle of this mean believes it.
  Eigen::Isometry3d apply(const CalibrationMean& mean) const;

  /// J P J^T: what the calibration adds to the motion's covariance (right perturbation).
  Matrix6d added_covariance() const;

  /// The particle moved by apply(mean) * exp(residual), where the noise was `noise` without the added part.
  void learn(const Vector6d& residual, CalibrationMean& mean) const { mean += gain_ * residual; }

  /// Call once after begin(), before learn().
  void prepare_gain(const Matrix6d& noise);
  /// Ends the step: covariance after it, plus the random walk.
  void end();

  /// The calibration is known from elsewhere; never so well that it could not drift.
  void set_covariance(const Eigen::Matrix3d& covariance) { covariance_ = covariance + least_covariance_; }

  /// J of the step.
  const Eigen::Matrix<double, 6, 3>& jacobian() const { return jacobian_; }
  const Eigen::Matrix3d& covariance() const { return covariance_; }

 private:
  Eigen::Vector3d walk_;  // variance a metre
  Eigen::Matrix3d covariance_, least_covariance_;
  Vector6d measured_ = Vector6d::Zero();
  Eigen::Matrix<double, 6, 3> jacobian_ = Eigen::Matrix<double, 6, 3>::Zero();
  Eigen::Matrix<double, 3, 6> gain_ = Eigen::Matrix<double, 3, 6>::Zero();
  bool on_ = false, active_ = false;
};

}  // namespace lcmslam
