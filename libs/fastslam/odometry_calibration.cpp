#include <lcmslam/fastslam/odometry_calibration.hpp>

#include <Eigen/Cholesky>

namespace lcmslam {

CalibrationMean calibration_sigmas(const FastSlamSettings& s) {
  CalibrationMean sigma;
  sigma << s.way_scale_sigma, s.heading_scale_sigma, s.heading_per_m_sigma, s.side_per_m_sigma;
  return sigma;
}

OdometryCalibration::OdometryCalibration(const FastSlamSettings& s) {
  const CalibrationMean sigma = calibration_sigmas(s);
  covariance_ = sigma.cwiseAbs2().asDiagonal();
  walk_ = (s.calibration_walk * sigma).cwiseAbs2();
  least_covariance_ = 0.01 * covariance_;
  on_ = sigma.maxCoeff() > 0;
}

void OdometryCalibration::begin(const Motion& odometry) {
  active_ = on_ && !odometry.visual;
  measured_ = se3_log(odometry.T_from_to);
  jacobian_.setZero();
  gain_.setZero();
  if (!active_) return;
  jacobian_.col(0).head<3>() = measured_.head<3>();
  jacobian_.col(1).tail<3>() = measured_.tail<3>();
  jacobian_(5, 2) = measured_.head<3>().norm();
  jacobian_.col(3).head<2>() << -measured_.y(), measured_.x();
}

Eigen::Isometry3d OdometryCalibration::apply(const CalibrationMean& mean) const {
  return se3_exp(measured_ + jacobian_ * mean);
}

Matrix6d OdometryCalibration::added_covariance() const {
  return jacobian_ * covariance_ * jacobian_.transpose();
}

void OdometryCalibration::prepare_gain(const Matrix6d& noise) {
  if (!active_) return;
  const Matrix6d S = added_covariance() + noise;
  gain_ = S.llt().solve(jacobian_ * covariance_).transpose();
}

void OdometryCalibration::end() {
  if (!active_) return;
  covariance_ -= (gain_ * jacobian_ * covariance_).eval();
  covariance_.diagonal() += walk_ * measured_.head<3>().norm();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
}

}  // namespace lcmslam
