#pragma once
// Where on a recording's truth body does the camera sit, and by how much do their clocks differ? Found by all
// poses of a mapper that ran over the whole recording. For evaluation alone: it makes truth agree with itself
// to what images can tell, and takes a constant error of the mapper for the truth's.

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include <lcmslam/evaluation/trajectory.hpp>

namespace lcmslam {

struct TruthFit {
  double clock_offset = 0;  ///< s, what the truth's clock shows more than the camera's
  Eigen::Isometry3d T_truth_camera = Eigen::Isometry3d::Identity();
  double rms_translation = 0, rms_rotation = 0;  ///< m, rad, of what is left
};

/// T_world_map by all poses that have a truth: least squares of se3 errors, as below.
inline Eigen::Isometry3d fit_world(const Trajectory& truth, const Trajectory& path) {
  std::optional<Eigen::Isometry3d> T_world_map;
  for (int step = 0; step < 10; ++step) {
    Matrix6d normal = Matrix6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    for (const StampedPose& pose : path) {
      const auto T_world_robot = pose_at(truth, pose.utime);
      if (!T_world_robot) continue;
      if (!T_world_map) T_world_map = *T_world_robot * pose.T_world_body.inverse();
      // (W exp(w) P)^-1 T = exp(-Ad(P^-1) w) P^-1 W^-1 T
      const Vector6d error = se3_log((*T_world_map * pose.T_world_body).inverse() * *T_world_robot);
      const Matrix6d J = adjoint(pose.T_world_body.inverse());
      normal += J.transpose() * J;
      gradient += J.transpose() * error;
    }
    if (!T_world_map) throw std::invalid_argument("no pose has a truth");
    T_world_map = *T_world_map * se3_exp(normal.ldlt().solve(gradient));
  }
  return *T_world_map;
}

/// W T_truth(t) Z = T_estimate(t): least squares of se3 errors, 1 cm as heavy as 1/100 rad.
inline TruthFit fit_body(const Trajectory& truth, const Trajectory& camera, double clock_offset,
                         const Eigen::Isometry3d& T_truth_camera) {
  TruthFit fit{clock_offset, T_truth_camera, 0, 0};
  std::vector<std::pair<Eigen::Isometry3d, Eigen::Isometry3d>> pairs;  // truth, estimate
  for (const StampedPose& pose : camera)
    if (const auto T = pose_at(truth, pose.utime + std::llround(1e6 * clock_offset), 0.1))
      pairs.emplace_back(*T, pose.T_world_body);
  if (pairs.size() < 10) throw std::invalid_argument("fewer than 10 poses have a truth");
  Eigen::Isometry3d W = pairs[0].second * (pairs[0].first * fit.T_truth_camera).inverse();
  for (int step = 0; step < 20; ++step) {
    Eigen::Matrix<double, 12, 12> normal = Eigen::Matrix<double, 12, 12>::Zero();
    Eigen::Matrix<double, 12, 1> gradient = Eigen::Matrix<double, 12, 1>::Zero();
    double translation2 = 0, rotation2 = 0;
    for (const auto& [T, E] : pairs) {
      const Eigen::Isometry3d T_Z = T * fit.T_truth_camera;
      const Vector6d error = se3_log(E.inverse() * W * T_Z);
      Eigen::Matrix<double, 6, 12> J;
      J << adjoint(T_Z.inverse()), Matrix6d::Identity();
      normal += J.transpose() * J;
      gradient += J.transpose() * error;
      translation2 += error.head<3>().squaredNorm();
      rotation2 += error.tail<3>().squaredNorm();
    }
    const auto count = static_cast<double>(pairs.size());
    fit.rms_translation = std::sqrt(translation2 / count);
    fit.rms_rotation = std::sqrt(rotation2 / count);
    const Eigen::Matrix<double, 12, 1> update = -normal.ldlt().solve(gradient);
    W = W * se3_exp(update.head<6>());
    fit.T_truth_camera = fit.T_truth_camera * se3_exp(update.tail<6>());
  }
  return fit;
}

/// Of the clocks within 40 ms, each 1 ms, that with the least errors.
inline TruthFit fit_truth(const Trajectory& truth, const Trajectory& camera,
                          const Eigen::Isometry3d& T_truth_camera) {
  TruthFit best;
  double least = std::numeric_limits<double>::infinity();
  for (int ms = -40; ms <= 40; ++ms) {
    const TruthFit fit = fit_body(truth, camera, 1e-3 * ms, T_truth_camera);
    const double cost = fit.rms_translation * fit.rms_translation + fit.rms_rotation * fit.rms_rotation;
    if (cost >= least) continue;
    least = cost;
    best = fit;
  }
  return best;
}

}  // namespace lcmslam
