#pragma once
// One landmark of one particle: a 3-D Gaussian in the world, conditioned on the particle's path, and
// its extended Kalman filter, for every measurement model alike. For points the model is linear in the
// landmark given the pose, so that the filter is exact.
//
//   z = g(p) + noise,  p = R^T (m - t)      thesis 2.6-2.8 for points, pose T_world_robot = (R, t)
//   H = dz/dm = G R^T,  G = dg/dp           measurement_model.hpp
//   S = H Sigma H^T + R_z                   innovation covariance, 2.5 corrected

#include <Eigen/Geometry>

#include <lcmslam/fastslam/landmarks/measurement_model.hpp>

namespace lcmslam {

struct LandmarkGaussian {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();            ///< m, world
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< m^2, world
};

/// What one measurement says about one landmark, seen from one pose.
struct Innovation {
  Eigen::Vector3d residual;   ///< z - h(m)
  Eigen::Vector3d predicted;  ///< p, the landmark in the robot frame (m)
  Eigen::Matrix3d landmark;   ///< H Sigma H^T
  Eigen::Matrix3d inverse;    ///< S^-1
  double distance2 = 0;       ///< d^2 = residual^T S^-1 residual
  double log_peak = 0;        ///< log |2 pi S|^-1/2 over the measured components
};

/// S = H Sigma H^T + R_z.
Eigen::Matrix3d innovation_covariance(const LandmarkGaussian& landmark, const Measurement& measurement,
                                      const Eigen::Isometry3d& T_world_robot);

Innovation innovate(const LandmarkGaussian& landmark, const Measurement& measurement,
                    const Eigen::Isometry3d& T_world_robot);

/// A landmark from its first measurement. For points: mean by 2.1-2.3, covariance by 2.4 corrected, (H^T
/// R_z^-1 H)^-1 = R R_z R^T. Throws std::invalid_argument for a bearing.
LandmarkGaussian make_landmark(const Measurement& measurement, const Eigen::Isometry3d& T_world_robot);

/// Kalman update with an innovation of the same landmark, measurement and pose. `added_variance` (m^2)
/// is added after it, in the directions that are measured.
LandmarkGaussian update_landmark(const LandmarkGaussian& landmark, const Innovation& innovation,
                                 const Measurement& measurement, const Eigen::Isometry3d& T_world_robot,
                                 double added_variance);

}  // namespace lcmslam
