// PathSmoother: the Gaussian about the solution, by the sparse Cholesky root of its information.

#include <lcmslam/fastslam/smoothing/path_graph.hpp>
#include <lcmslam/fastslam/smoothing/path_smoother.hpp>

namespace lcmslam {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
using SparseRoot = Eigen::SimplicialLLT<SparseMatrix>;

Eigen::Vector3d standard_normal(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

Eigen::Matrix3d block3(const SparseMatrix& H, Eigen::Index at) {
  return Eigen::Matrix3d(H.block(at, at, 3, 3));
}

// Root of the covariance that the sensor's calibration adds to the newest pose (columns from `newest`) as
// seen from the first: with H of all, s at its end, and the root of H_xx without the sensor,
//   dx/ds = -H_xx^-1 H_xs,   covariance of s = (H_ss - H_sx H_xx^-1 H_xs)^-1.
Eigen::Matrix3d sensor_root(const SparseMatrix& H, const SparseRoot& root, Eigen::Index newest) {
  const Eigen::Index n = H.rows() - 3;
  const Eigen::MatrixXd H_xs = H.block(0, n, n, 3);
  const Eigen::MatrixXd by_sensor = -root.solve(H_xs);
  const Eigen::Matrix3d H_ss = block3(H, n) + H_xs.transpose() * by_sensor;
  return H_ss.llt().matrixU().solve<Eigen::OnTheRight>(by_sensor.middleRows<3>(newest).eval());
}

}  // namespace

// Columns of H: poses but the first, landmarks, the odometry's calibration.
struct PathSmoother::Graph::Posterior {
  SparseRoot root;       // P H P^T = L L^T
  SparseMatrix by_path;  // H's rows from `landmarks` on, the columns of poses
  Eigen::Index landmarks, calibration;
  std::vector<Eigen::Matrix2d> landmark_covariances;  // given the path
  CalibrationCovariance calibration_covariance;       // given the path
  Eigen::Matrix3d motion_root;                        // of the noise since the newest pose
  Eigen::Matrix3d sensor_root;

  Eigen::Index newest() const { return landmarks - 3; }
};

// Normal equations at the solution; columns as in Posterior, then the sensor's calibration. Empty when a
// residual has no value there.
SparseMatrix PathSmoother::Graph::information() const {
  const auto block = [](const auto& parameters) { return const_cast<double*>(parameters.data()); };
  ceres::Problem::EvaluateOptions options;
  for (std::size_t i = 1; i < poses.size(); ++i) options.parameter_blocks.push_back(block(poses[i]));
  for (const auto& [id, landmark] : landmarks) options.parameter_blocks.push_back(block(landmark));
  options.parameter_blocks.push_back(block(calibration));
  options.parameter_blocks.push_back(block(sensor));
  ceres::CRSMatrix J;
  if (!problem->Evaluate(options, nullptr, nullptr, nullptr, &J)) return {};
  const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> mapped(
      J.num_rows, J.num_cols, static_cast<Eigen::Index>(J.values.size()), J.rows.data(), J.cols.data(),
      J.values.data());
  const SparseMatrix columns = mapped;
  return SparseMatrix(columns.transpose()) * columns;
}

bool PathSmoother::Graph::find_posterior(Posterior& p) const {
  if (!solved) return false;
  const SparseMatrix all = information();
  const Eigen::Map<const Eigen::VectorXd> values(all.valuePtr(), all.nonZeros());
  if (all.rows() == 0 || !values.allFinite()) return false;
  const SparseMatrix H = all.topLeftCorner(all.rows() - 3, all.cols() - 3);
  p.root.compute(H);
  if (p.root.info() != Eigen::Success) return false;
  p.landmarks = static_cast<Eigen::Index>(3 * (poses.size() - 1));
  p.calibration = H.rows() - calibration_size;
  p.by_path = H.bottomLeftCorner(H.rows() - p.landmarks, p.landmarks);
  for (auto at = p.landmarks; at < p.calibration; at += 2)
    p.landmark_covariances.emplace_back(
        Eigen::Matrix2d(H.block(at, at, 2, 2)).llt().solve(Eigen::Matrix2d::Identity()));
  p.calibration_covariance = CalibrationCovariance(H.bottomRightCorner(calibration_size, calibration_size))
                                 .llt()
                                 .solve(CalibrationCovariance::Identity());
  p.motion_root = (reduce(covariance) + 1e-12 * Eigen::Matrix3d::Identity()).llt().matrixL();
  p.sensor_root.setZero();
  if (sensor_may_err()) p.sensor_root = lcmslam::sensor_root(all, p.root, p.newest());
  return true;
}

// A draw in the same world as the mode: the first pose is held, but the world is the whole path's.
Eigen::Isometry3d PathSmoother::Graph::T_world_draw(const Eigen::VectorXd& delta) const {
  return fit(
      [&](std::size_t i) -> Eigen::Vector2d {
        return i == 0 ? position(i)
                      : Eigen::Vector2d(position(i) + delta.segment<2>(static_cast<Eigen::Index>(3 * i) - 3));
      },
      [&](std::size_t i) { return position(i); });
}

// The mode without `random`.
PathSample PathSmoother::Graph::draw(const Posterior& p, Random* random) const {
  Eigen::VectorXd normal = Eigen::VectorXd::Zero(p.root.rows());
  for (Eigen::Index i = 0; i < normal.size() && random; ++i) normal(i) = random->normal();
  const Eigen::VectorXd delta = p.root.permutationPinv() * p.root.matrixU().solve(normal).eval();
  const Eigen::VectorXd pull = p.by_path * delta.head(p.landmarks);  // H_bp delta_p for each block b
  const Eigen::Isometry3d T = T_world_draw(delta);
  const Eigen::Matrix2d R = T.linear().topLeftCorner<2, 2>();

  // Mean of a block given the path: x* - H_bb^-1 H_bp delta_p.
  PathSample sample;
  std::size_t i = 0;
  for (const auto& [id, landmark] : landmarks) {
    const Eigen::Matrix2d& given_path = p.landmark_covariances[i];
    const Eigen::Vector2d shift = -given_path * pull.segment<2>(static_cast<Eigen::Index>(2 * i));
    ++i;
    LandmarkGaussian& gaussian = sample.landmarks[id];
    gaussian.mean = T * Eigen::Vector3d(landmark[0] + shift.x(), landmark[1] + shift.y(), 0);
    gaussian.covariance = plane_variance * Eigen::Matrix3d::Identity();
    const Eigen::Matrix2d turned = R * given_path * R.transpose();
    gaussian.covariance.topLeftCorner<2, 2>() = 0.5 * (turned + turned.transpose());
  }
  sample.calibration = calibration - p.calibration_covariance * pull.tail<calibration_size>();

  // The newest pose, and the motion since.
  const Eigen::Vector3d newest =
      Eigen::Map<const Eigen::Vector3d>(poses.back().data()) + Eigen::Vector3d(delta.segment<3>(p.newest()));
  Vector6d correction = jacobian * sample.calibration;
  if (random) correction += PoseSpace<3>::expand((p.motion_root * standard_normal(*random)).eval());
  const Eigen::Isometry3d T_draw_newest = planar_pose(newest.x(), newest.y(), newest.z());
  sample.T_world_robot =
      T * T_draw_newest * T_pose_now * se3_exp(PoseSpace<3>::expand(PoseSpace<3>::reduce(correction)));

  // The sensor's calibration that all samples share may be wrong: as if the path had begun elsewhere.
  Eigen::Vector3d otherwise = newest;
  if (random && sensor_may_err()) otherwise += p.sensor_root * standard_normal(*random);
  sample.T_world_start =
      T * T_draw_newest * planar_pose(otherwise.x(), otherwise.y(), otherwise.z()).inverse() * pose(0);
  return sample;
}

std::vector<PathSample> PathSmoother::sample(std::size_t count, Random& random,
                                             CalibrationCovariance& calibration_covariance) {
  std::vector<PathSample> samples;
  Graph::Posterior posterior;
  if (graph_->poses.size() < 2 || graph_->residuals == 0 || !graph_->find_posterior(posterior))
    return samples;
  calibration_covariance = posterior.calibration_covariance;
  for (std::size_t k = 0; k < count; ++k)
    samples.push_back(graph_->draw(posterior, k == 0 ? nullptr : &random));
  return samples;
}

}  // namespace lcmslam
