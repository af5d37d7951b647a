#pragma once
// What path_smoother.cpp solves and path_posterior.cpp draws from: poses, landmarks and calibrations as Ceres
// knows them.

#include <ceres/ceres.h>
#include <Eigen/SparseCholesky>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <memory>
#include <vector>

#include <lcmslam/fastslam/pose_space.hpp>
#include <lcmslam/fastslam/smoothing/path_smoother.hpp>

namespace lcmslam {

inline Eigen::Vector3d planar(const Eigen::Isometry3d& T) {
  return {T.translation().x(), T.translation().y(), yaw(T)};
}

struct PathSmoother::Graph {
  explicit Graph(const FastSlamSettings& settings);

  void add_pose(Utime utime, const Eigen::Isometry3d& T_world_robot, const Matrix6d& covariance_then);

  // Moves path and map as one to where the filter had the path.
  void place_world();

  Eigen::Isometry3d pose(std::size_t i) const { return planar_pose(poses[i][0], poses[i][1], poses[i][2]); }

  Eigen::Matrix3d reduce(const Matrix6d& full) const { return PoseSpace<3>::reduce(full); }

  Eigen::Vector2d position(std::size_t i) const { return {poses[i][0], poses[i][1]}; }

  // The motion in the plane that brings points to others, one for each pose, by the poses' weights.
  template <class From, class To>
  Eigen::Isometry3d fit(From from, To to) const {
    Eigen::Vector2d from_mean = Eigen::Vector2d::Zero(), to_mean = Eigen::Vector2d::Zero();
    double sum = 0, cosine = 0, sine = 0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      from_mean += published[i].weight * from(i);
      to_mean += published[i].weight * to(i);
      sum += published[i].weight;
    }
    from_mean /= sum;
    to_mean /= sum;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Eigen::Vector2d p = from(i) - from_mean, q = to(i) - to_mean;
      cosine += published[i].weight * p.dot(q);
      sine += published[i].weight * (p.x() * q.y() - p.y() * q.x());
    }
    const double turn = std::atan2(sine, cosine);
    const Eigen::Vector2d t = to_mean - Eigen::Rotation2Dd(turn) * from_mean;
    return planar_pose(t.x(), t.y(), turn);
  }

  // path_posterior.cpp: the Gaussian about the solution.
  using SparseMatrix = Eigen::SparseMatrix<double>;
  struct Posterior;
  SparseMatrix information() const;
  bool find_posterior(Posterior& posterior) const;  // false: not solved, or singular
  bool sensor_may_err() const { return sensor_sigma.maxCoeff() > 1e-9; }
  Eigen::Isometry3d T_world_draw(const Eigen::VectorXd& delta) const;
  PathSample draw(const Posterior& posterior, Random* random) const;

  std::unique_ptr<ceres::LossFunction> robust;
  std::unique_ptr<ceres::Problem> problem;
  Eigen::Vector3d sensor_sigma;
  std::deque<std::array<double, 3>> poses;  // x, y, heading; a deque: addresses stay
  std::vector<Utime> utimes;
  struct Published {
    Eigen::Vector2d position;
    double weight;
  };
  std::vector<Published> published;  // by the filter, of each pose
  std::map<std::int32_t, std::array<double, 2>> landmarks;
  std::map<std::int32_t, std::size_t> observations;  // of each landmark
  CalibrationMean calibration = CalibrationMean::Zero();
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();
  // Since the newest pose: steps without an observation make one motion.
  Eigen::Isometry3d T_pose_now = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();
  CalibrationJacobian jacobian = CalibrationJacobian::Zero();
  std::size_t residuals = 0;  // of observations
  bool solved = false;
};

}  // namespace lcmslam
