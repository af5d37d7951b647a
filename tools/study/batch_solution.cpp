#include "tools/study/batch_solution.hpp"

#include <ceres/ceres.h>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

namespace lcmslam {
namespace {

struct OdometryFactor {
  Eigen::Vector3d step, sigma;
  template <class T>
  bool operator()(const T* a, const T* b, T* r) const {
    const T c = cos(a[2]), s = sin(a[2]), dx = b[0] - a[0], dy = b[1] - a[1];
    const T turn = b[2] - a[2] - step.z();
    r[0] = (c * dx + s * dy - step.x()) / sigma.x();
    r[1] = (-s * dx + c * dy - step.y()) / sigma.y();
    r[2] = (turn - 2 * M_PI * ceres::floor((turn + M_PI) / (2 * M_PI))) / sigma.z();
    return true;
  }
};

struct OffsetFactor {
  Eigen::Vector2d offset;
  double sigma;
  template <class T>
  bool operator()(const T* pose, const T* landmark, T* r) const {
    const T c = cos(pose[2]), s = sin(pose[2]), dx = landmark[0] - pose[0], dy = landmark[1] - pose[1];
    r[0] = (c * dx + s * dy - offset.x()) / sigma;
    r[1] = (-s * dx + c * dy - offset.y()) / sigma;
    return true;
  }
};

// Standard deviations of a step's x, y and heading, from the accumulated covariances.
Eigen::Vector3d step_sigma(const MotionSample& a, const MotionSample& b, const Eigen::Isometry3d& step) {
  const Matrix6d A = adjoint(step.inverse());
  const Matrix6d Q = b.covariance - A * a.covariance * A.transpose();
  return Eigen::Vector3d(Q(0, 0), Q(1, 1), Q(5, 5)).cwiseMax(1e-12).cwiseSqrt();
}

double rms(ceres::Problem& problem, const std::vector<ceres::ResidualBlockId>& blocks) {
  ceres::Problem::EvaluateOptions options;
  options.residual_blocks = blocks;
  std::vector<double> residuals;
  problem.Evaluate(options, nullptr, &residuals, nullptr, nullptr);
  double squares = 0;
  for (const double r : residuals) squares += r * r;
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, residuals.size())));
}

}  // namespace

BatchSolution solve_batch(const LandmarkRecording& recording) {
  const std::size_t n = recording.odometry.size();
  if (n < 2 || recording.frames.size() != n)
    throw std::invalid_argument("the batch solution needs odometry as poses, one for each frame");
  BatchSolution solution;
  std::vector<std::array<double, 3>> poses(n, {0, 0, 0});
  std::map<int, std::array<double, 2>> landmarks;
  std::vector<ceres::ResidualBlockId> of_odometry, of_landmarks;
  const auto pose = [&](std::size_t i) { return planar_pose(poses[i][0], poses[i][1], poses[i][2]); };
  ceres::Problem problem;
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0) {
      const MotionSample &a = recording.odometry[i - 1], &b = recording.odometry[i];
      const Eigen::Isometry3d step = a.T_odom_robot.inverse() * b.T_odom_robot;
      const Eigen::Isometry3d T = pose(i - 1) * step;
      poses[i] = {T.translation().x(), T.translation().y(), yaw(T)};
      auto* factor = new OdometryFactor{{step.translation().x(), step.translation().y(), yaw(step)},
                                        step_sigma(a, b, step)};
      of_odometry.push_back(
          problem.AddResidualBlock(new ceres::AutoDiffCostFunction<OdometryFactor, 3, 3, 3>(factor), nullptr,
                                   poses[i - 1].data(), poses[i].data()));
    }
    for (const Feature& f : recording.frames[i].features) {
      if (f.kind != MeasurementKind::planar || f.landmark_id < 0)
        throw std::invalid_argument("the batch solution takes planar offsets of known identity");
      const Eigen::Vector3d p = f.point.cast<double>(), m = pose(i) * p;
      auto& landmark =
          landmarks.try_emplace(f.landmark_id, std::array<double, 2>{m.x(), m.y()}).first->second;
      auto* factor = new OffsetFactor{p.head<2>(), static_cast<double>(f.depth_sigma)};
      of_landmarks.push_back(
          problem.AddResidualBlock(new ceres::AutoDiffCostFunction<OffsetFactor, 2, 3, 2>(factor), nullptr,
                                   poses[i].data(), landmark.data()));
    }
    if (i == 1) problem.SetParameterBlockConstant(poses[0].data());
    if (i % 100 != 99 && i + 1 != n) continue;
    const bool whole = i + 1 == n;  // solved until it moves by less than a millimetre
    options.max_num_iterations = whole ? 200 : 8;
    options.function_tolerance = whole ? 1e-9 : 1e-6;
    ceres::Solve(options, &problem, &summary);
  }
  solution.converged = summary.termination_type == ceres::CONVERGENCE;
  solution.cost = summary.final_cost;
  solution.residuals = static_cast<std::size_t>(problem.NumResiduals());
  solution.odometry_rms = rms(problem, of_odometry);
  solution.landmark_rms = rms(problem, of_landmarks);
  for (std::size_t i = 0; i < n; ++i) solution.path.push_back({recording.odometry[i].utime, pose(i)});
  return solution;
}

}  // namespace lcmslam
