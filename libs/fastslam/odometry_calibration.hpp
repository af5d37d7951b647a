#pragma once
// Systematic errors of the odometry, learned while driving. Wheels of unequal radius, a steering offset or
// a wrong scale make errors that go the same way for minutes; taken for white noise they make a filter
// overconfident (Victoria Park: heading turns by 1.4 mrad a metre, a random walk of the stated noise would
// give a tenth of that over a lap). And where the head looks aside of where the wheels roll, the base seems
// to slip as it drives: tyres that are known to hold it sideways would bend the path instead. The calibration
// c is a linear Gaussian part of each particle's state:
//
//   motion(c) = exp(xi + J(xi) c),   xi = log of the measured motion,   c = (scale of the way, scale of the
//   heading, heading per metre, side per metre),   c a random walk over the way driven
//
// Given the particle's path it has a closed form (Rao-Blackwell): each step's drawn motion is a measurement
// of c. J depends on the odometry alone, so that all particles share the covariance and differ in the mean.

#include <lcmslam/fastslam/pose_space.hpp>
#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

constexpr int calibration_size = 4;
using CalibrationMean = Eigen::Matrix<double, calibration_size, 1>;
using CalibrationCovariance = Eigen::Matrix<double, calibration_size, calibration_size>;
using CalibrationJacobian = Eigen::Matrix<double, 6, calibration_size>;

/// Of each component, before anything was driven.
CalibrationMean calibration_sigmas(const FastSlamSettings& settings);

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
  void set_covariance(const CalibrationCovariance& covariance) {
    covariance_ = covariance + least_covariance_;
  }

  /// J of the step.
  const CalibrationJacobian& jacobian() const { return jacobian_; }
  const CalibrationCovariance& covariance() const { return covariance_; }

 private:
  CalibrationMean walk_;  // variance a metre
  CalibrationCovariance covariance_, least_covariance_;
  Vector6d measured_ = Vector6d::Zero();
  CalibrationJacobian jacobian_ = CalibrationJacobian::Zero();
  Eigen::Matrix<double, calibration_size, 6> gain_ = Eigen::Matrix<double, calibration_size, 6>::Zero();
  bool on_ = false, active_ = false;
};

}  // namespace lcmslam
