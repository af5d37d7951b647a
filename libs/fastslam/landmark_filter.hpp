#pragma once
// One landmark of one particle: a 3-D Gaussian in the world, conditioned on the particle's path, and
// its extended Kalman filter. Given the pose the measurement model is linear in the landmark, so the
// filter is exact.
//
//   z = h(m) + noise,  h(m) = R^T (m - t)      thesis 2.6-2.8, pose T_world_robot = (R, t)
//   G = dh/dm = R^T
//   S = G Sigma G^T + R_z                      innovation covariance, 2.5 corrected

#include <Eigen/Geometry>

#include "fastslam/persistent_array.hpp"

namespace lcmslam {

struct LandmarkGaussian {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();            ///< m, world
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< m^2, world
};

/// A particle's landmarks by slot (see LandmarkIndex).
using ParticleMap = PersistentArray<LandmarkGaussian>;

/// A measured point in the robot frame.
struct PointMeasurement {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();           ///< m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< m^2
};

/// What one measurement says about one landmark, seen from one pose.
struct Innovation {
  Eigen::Vector3d residual;  ///< z - h(m), robot frame
  Eigen::Matrix3d landmark;  ///< G Sigma G^T
  Eigen::Matrix3d inverse;   ///< S^-1
  double distance2 = 0;      ///< d^2 = residual^T S^-1 residual
  double log_peak = 0;       ///< log |2 pi S|^-1/2
};

/// h(m): the landmark's position in the robot frame.
inline Eigen::Vector3d predict_measurement(const Eigen::Vector3d& mean,
                                           const Eigen::Isometry3d& T_world_robot) {
  return T_world_robot.linear().transpose() * (mean - T_world_robot.translation());
}

Innovation innovate(const LandmarkGaussian& landmark, const PointMeasurement& measurement,
                    const Eigen::Isometry3d& T_world_robot);

/// A landmark from its first measurement: mean by 2.1-2.3, covariance by 2.4 corrected,
/// (G^T R_z^-1 G)^-1 = R R_z R^T.
LandmarkGaussian make_landmark(const PointMeasurement& measurement, const Eigen::Isometry3d& T_world_robot);

/// Kalman update with an innovation of the same landmark, measurement and pose.
/// `added_variance` (m^2) is added after it.
LandmarkGaussian update_landmark(const LandmarkGaussian& landmark, const Innovation& innovation,
                                 const PointMeasurement& measurement, const Eigen::Isometry3d& T_world_robot,
                                 double added_variance);

}  // namespace lcmslam
