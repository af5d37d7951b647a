#include <lcmslam/fastslam/smoothing/path_smoother.hpp>

#include <lcmslam/fastslam/smoothing/path_factors.hpp>
#include <lcmslam/fastslam/smoothing/path_graph.hpp>

namespace lcmslam {

PathSmoother::Graph::Graph(const FastSlamSettings& s)
    : robust(new ceres::CauchyLoss(s.huber_width)),
      sensor_sigma(std::max(1e-9, s.range_offset_sigma), std::max(1e-9, s.range_scale_sigma),
                   std::max(1e-9, s.bearing_offset_sigma)) {
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem = std::make_unique<ceres::Problem>(options);
  constexpr int n = calibration_size;
  auto* prior = new ceres::AutoDiffCostFunction<CalibrationPrior<n>, n, n>(
      new CalibrationPrior<n>{calibration_sigmas(s).cwiseMax(1e-9)});
  problem->AddResidualBlock(prior, nullptr, calibration.data());
  auto* of_sensor =
      new ceres::AutoDiffCostFunction<CalibrationPrior<3>, 3, 3>(new CalibrationPrior<3>{sensor_sigma});
  problem->AddResidualBlock(of_sensor, nullptr, sensor.data());
}

void PathSmoother::Graph::add_pose(Utime utime, const Eigen::Isometry3d& T_world_robot,
                                   const Matrix6d& covariance_then) {
  published.push_back(
      {T_world_robot.translation().head<2>(), 1 / (1e-9 + covariance_then.topLeftCorner<2, 2>().trace())});
  const Eigen::Vector3d x = planar(T_world_robot);
  poses.push_back({x.x(), x.y(), x.z()});
  utimes.push_back(utime);
}

void PathSmoother::Graph::place_world() {
  const Eigen::Isometry3d T =
      fit([&](std::size_t i) { return position(i); }, [&](std::size_t i) { return published[i].position; });
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector3d moved = planar(T * pose(i));
    poses[i] = {moved.x(), moved.y(), moved.z()};
  }
  for (auto& [id, landmark] : landmarks) {
    const Eigen::Vector3d moved = T * Eigen::Vector3d(landmark[0], landmark[1], 0);
    landmark = {moved.x(), moved.y()};
  }
}

PathSmoother::PathSmoother(const FastSlamSettings& settings) : graph_(std::make_unique<Graph>(settings)) {}
PathSmoother::~PathSmoother() = default;

void PathSmoother::add(Utime utime, const Motion& motion, const CalibrationJacobian& calibration_jacobian,
                       const std::vector<IdentifiedMeasurement>& seen, const Eigen::Isometry3d& T_world_robot,
                       const Matrix6d& covariance) {
  Graph& g = *graph_;
  const bool first = g.poses.empty();
  if (first) {
    g.add_pose(utime, T_world_robot, covariance);
  } else {
    const Matrix6d A = adjoint(motion.T_from_to.inverse());
    g.T_pose_now = g.T_pose_now * motion.T_from_to;
    g.covariance = (A * g.covariance * A.transpose() + motion.covariance).eval();
    g.jacobian = (A * g.jacobian + calibration_jacobian).eval();
    if (seen.empty()) return;
    auto* error = new OdometryError;
    error->z = planar(g.T_pose_now);
    for (int i = 0; i < 3; ++i) error->J.row(i) = g.jacobian.row(PoseSpace<3>::row(i));
    error->root_information = root_information(g.reduce(g.covariance));
    g.add_pose(utime, T_world_robot, covariance);
    double* before = g.poses[g.poses.size() - 2].data();
    g.problem->AddResidualBlock(
        new ceres::AutoDiffCostFunction<OdometryError, 3, 3, 3, calibration_size>(error), nullptr, before,
        g.poses.back().data(), g.calibration.data());
    if (g.poses.size() == 2) g.problem->SetParameterBlockConstant(before);
    g.T_pose_now.setIdentity();
    g.covariance.setZero();
    g.jacobian.setZero();
  }
  for (const IdentifiedMeasurement& m : seen) {
    auto [landmark, added] = g.landmarks.try_emplace(m.landmark_id);
    if (added) {
      const Eigen::Vector3d mean = make_landmark(sensor().corrected(m.measurement), T_world_robot).mean;
      landmark->second = {mean.x(), mean.y()};
    }
    auto* error = new LandmarkError{
        m.measurement, root_information<Eigen::Matrix2d>(m.measurement.covariance.topLeftCorner<2, 2>())};
    g.problem->AddResidualBlock(new ceres::AutoDiffCostFunction<LandmarkError, 2, 3, 2, 3>(error),
                                g.robust.get(), g.poses.back().data(), landmark->second.data(),
                                g.sensor.data());
    ++g.observations[m.landmark_id];
    ++g.residuals;
  }
}

void PathSmoother::forget(std::int32_t landmark_id) {
  Graph& g = *graph_;
  const auto landmark = g.landmarks.find(landmark_id);
  if (landmark == g.landmarks.end()) return;
  g.residuals -= g.observations[landmark_id];
  g.problem->RemoveParameterBlock(landmark->second.data());  // and its residuals
  g.observations.erase(landmark_id);
  g.landmarks.erase(landmark);
}

std::size_t PathSmoother::size() const {
  return graph_->poses.size();
}

double PathSmoother::solve() {
  Graph& g = *graph_;
  if (g.poses.size() < 2 || g.residuals == 0) return 0;
  ceres::Solver::Options options;
  options.num_threads = 1;  // the same result everywhere
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.max_num_iterations = 30;
  options.function_tolerance = 1e-5;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, g.problem.get(), &summary);
  g.solved = summary.IsSolutionUsable();
  if (!g.solved) return 0;
  g.place_world();
  return summary.final_cost / static_cast<double>(g.residuals);
}

std::vector<SmoothedPose> PathSmoother::path() const {
  std::vector<SmoothedPose> path;
  for (std::size_t i = 0; i < graph_->poses.size(); ++i) path.push_back({graph_->utimes[i], graph_->pose(i)});
  return path;
}

SensorCalibration PathSmoother::sensor() const {
  return {graph_->sensor.x(), graph_->sensor.y(), graph_->sensor.z()};
}

}  // namespace lcmslam
