#include "fastslam/landmark_filter.hpp"

#include <Eigen/LU>
#include <cmath>

namespace lcmslam {
namespace {

constexpr double kTwoPi = 6.283185307179586;

// R A R^T, exactly symmetric.
Eigen::Matrix3d rotated(const Eigen::Matrix3d& R, const Eigen::Matrix3d& A) {
  const Eigen::Matrix3d B = R * A * R.transpose();
  return 0.5 * (B + B.transpose());
}

}  // namespace

Innovation innovate(const LandmarkGaussian& landmark, const PointMeasurement& measurement,
                    const Eigen::Isometry3d& T_world_robot) {
  Innovation result;
  result.residual = measurement.point - predict_measurement(landmark.mean, T_world_robot);
  result.landmark = rotated(T_world_robot.linear().transpose(), landmark.covariance);
  const Eigen::Matrix3d S = result.landmark + measurement.covariance;
  result.inverse = S.inverse();
  result.distance2 = result.residual.dot(result.inverse * result.residual);
  result.log_peak = -0.5 * std::log(kTwoPi * kTwoPi * kTwoPi * S.determinant());
  return result;
}

LandmarkGaussian make_landmark(const PointMeasurement& measurement, const Eigen::Isometry3d& T_world_robot) {
  return {T_world_robot * measurement.point, rotated(T_world_robot.linear(), measurement.covariance)};
}

LandmarkGaussian update_landmark(const LandmarkGaussian& landmark, const Innovation& innovation,
                                 const PointMeasurement& measurement, const Eigen::Isometry3d& T_world_robot,
                                 double added_variance) {
  const Eigen::Matrix3d& R = T_world_robot.linear();
  const Eigen::Matrix3d gain = innovation.landmark * innovation.inverse;
  LandmarkGaussian result;
  result.mean = landmark.mean + R * (gain * innovation.residual);
  // P - P S^-1 P = P S^-1 R_z: no difference of large numbers, stays positive over any number of updates.
  result.covariance = rotated(R, gain * measurement.covariance);
  result.covariance.diagonal().array() += added_variance;
  return result;
}

}  // namespace lcmslam
