#include "fastslam/path_smoother.hpp"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <array>
#include <cmath>
#include <deque>

namespace lcmslam {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
using Jacobian63 = Eigen::Matrix<double, 6, 3>;

Eigen::Vector3d planar(const Eigen::Isometry3d& T) {
  return {T.translation().x(), T.translation().y(), yaw(T)};
}

template <class T>
T wrapped(const T& angle) {
  return angle - 2 * M_PI * ceres::floor((angle + M_PI) / (2 * M_PI));
}

// L^-1 (difference of the relative pose from z exp(J c)), Q = L L^T; right perturbation.
struct OdometryError {
  Eigen::Vector3d z;
  Eigen::Matrix3d J, root_information;

  template <class T>
  bool operator()(const T* a, const T* b, const T* c, T* residual) const {
    const T ca = cos(a[2]), sa = sin(a[2]);
    const double cz = std::cos(z.z()), sz = std::sin(z.z());
    const T dx = ca * (b[0] - a[0]) + sa * (b[1] - a[1]) - z.x();
    const T dy = -sa * (b[0] - a[0]) + ca * (b[1] - a[1]) - z.y();
    T e[3] = {cz * dx + sz * dy, -sz * dx + cz * dy, wrapped(T(b[2] - a[2] - z.z()))};
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) e[i] -= J(i, k) * c[k];
    for (int i = 0; i < 3; ++i) {
      residual[i] = T(0);
      for (int k = 0; k <= i; ++k) residual[i] += root_information(i, k) * e[k];
    }
    return true;
  }
};

// `sensor`: offset and scale of the range, offset of the bearing.
struct LandmarkError {
  Measurement z;
  Eigen::Matrix2d root_information;

  template <class T>
  bool operator()(const T* pose, const T* landmark, const T* sensor, T* residual) const {
    const T c = cos(pose[2]), s = sin(pose[2]);
    const T dx = landmark[0] - pose[0], dy = landmark[1] - pose[1];
    const T x = c * dx + s * dy, y = -s * dx + c * dy;
    T e[2] = {z.value.x() - x, z.value.y() - y};
    if (z.kind == MeasurementKind::range_bearing) {
      e[0] = z.value.x() - sensor[0] - (1.0 + sensor[1]) * sqrt(x * x + y * y + 1e-12);
      e[1] = wrapped(T(z.value.y() - sensor[2] - atan2(y, x)));
    }
    residual[0] = root_information(0, 0) * e[0];
    residual[1] = root_information(1, 0) * e[0] + root_information(1, 1) * e[1];
    return true;
  }
};

struct CalibrationPrior {
  Eigen::Vector3d sigma;
  template <class T>
  bool operator()(const T* c, T* residual) const {
    for (int i = 0; i < 3; ++i) residual[i] = c[i] / sigma(i);
    return true;
  }
};

Eigen::Vector3d standard_normal(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

// L^-1 of a covariance L L^T.
template <class Matrix>
Matrix root_information(const Matrix& covariance) {
  return covariance.llt().matrixL().solve(Matrix::Identity().eval());
}

}  // namespace

struct PathSmoother::Graph {
  explicit Graph(const FastSlamSettings& s)
      : robust(new ceres::CauchyLoss(s.huber_width)),
        sigma(std::max(1e-9, s.way_scale_sigma), std::max(1e-9, s.heading_scale_sigma),
              std::max(1e-9, s.heading_per_m_sigma)),
        sensor_sigma(std::max(1e-9, s.range_offset_sigma), std::max(1e-9, s.range_scale_sigma),
                     std::max(1e-9, s.bearing_offset_sigma)) {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem = std::make_unique<ceres::Problem>(options);
    auto* prior = new ceres::AutoDiffCostFunction<CalibrationPrior, 3, 3>(new CalibrationPrior{sigma});
    problem->AddResidualBlock(prior, nullptr, calibration.data());
    auto* of_sensor =
        new ceres::AutoDiffCostFunction<CalibrationPrior, 3, 3>(new CalibrationPrior{sensor_sigma});
    problem->AddResidualBlock(of_sensor, nullptr, sensor.data());
  }

  void add_pose(Utime utime, const Eigen::Isometry3d& T, const Matrix6d& T_covariance) {
    said.push_back({T.translation().head<2>(), 1 / (1e-9 + T_covariance.topLeftCorner<2, 2>().trace())});
    const Eigen::Vector3d x = planar(T);
    poses.push_back({x.x(), x.y(), x.z()});
    utimes.push_back(utime);
  }

  Eigen::Isometry3d pose(std::size_t i) const { return planar_pose(poses[i][0], poses[i][1], poses[i][2]); }

  Eigen::Matrix3d reduce(const Matrix6d& full) const { return PoseSpace<3>::reduce(full); }

  Eigen::Vector2d position(std::size_t i) const { return {poses[i][0], poses[i][1]}; }

  // The motion in the plane that brings points to others, one for each pose, by the poses' weights.
  template <class From, class To>
  Eigen::Isometry3d fit(From from, To to) const {
    Eigen::Vector2d from_mean = Eigen::Vector2d::Zero(), to_mean = Eigen::Vector2d::Zero();
    double sum = 0, cosine = 0, sine = 0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      from_mean += said[i].weight * from(i);
      to_mean += said[i].weight * to(i);
      sum += said[i].weight;
    }
    from_mean /= sum;
    to_mean /= sum;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Eigen::Vector2d p = from(i) - from_mean, q = to(i) - to_mean;
      cosine += said[i].weight * p.dot(q);
      sine += said[i].weight * (p.x() * q.y() - p.y() * q.x());
    }
    const double turn = std::atan2(sine, cosine);
    const Eigen::Vector2d t = to_mean - Eigen::Rotation2Dd(turn) * from_mean;
    return planar_pose(t.x(), t.y(), turn);
  }

  // Moves path and map as one to where the filter had the path.
  void place_world() {
    const Eigen::Isometry3d T =
        fit([&](std::size_t i) { return position(i); }, [&](std::size_t i) { return said[i].position; });
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Eigen::Vector3d moved = planar(T * pose(i));
      poses[i] = {moved.x(), moved.y(), moved.z()};
    }
    for (auto& [id, landmark] : landmarks) {
      const Eigen::Vector3d moved = T * Eigen::Vector3d(landmark[0], landmark[1], 0);
      landmark = {moved.x(), moved.y()};
    }
  }

  // Root of the covariance that the sensor's calibration adds to the newest pose as seen from the first: with
  // H of all (information(true)) and the root of H_xx without the sensor,
  //   dx/ds = -H_xx^-1 H_xs,   covariance of s = (H_ss - H_sx H_xx^-1 H_xs)^-1.
  Eigen::Matrix3d sensor_root(const SparseMatrix& H, const Eigen::SimplicialLLT<SparseMatrix>& root) const {
    const Eigen::Index n = H.rows() - 3, newest = static_cast<Eigen::Index>(3 * poses.size()) - 6;
    const Eigen::MatrixXd H_xs = H.block(0, n, n, 3);
    const Eigen::MatrixXd by_sensor = -root.solve(H_xs);
    const Eigen::Matrix3d H_ss = Eigen::Matrix3d(H.block(n, n, 3, 3)) + H_xs.transpose() * by_sensor;
    return H_ss.llt().matrixU().solve<Eigen::OnTheRight>(by_sensor.middleRows<3>(newest).eval());
  }

  // Normal equations at the solution; columns: poses but the first, landmarks, odometry's calibration, and
  // the sensor's if asked for.
  SparseMatrix information(bool with_sensor = false) {
    std::vector<double*> blocks;
    for (std::size_t i = 1; i < poses.size(); ++i) blocks.push_back(poses[i].data());
    for (auto& [id, landmark] : landmarks) blocks.push_back(landmark.data());
    blocks.push_back(calibration.data());
    if (with_sensor) blocks.push_back(sensor.data());
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = blocks;
    ceres::CRSMatrix J;
    problem->Evaluate(options, nullptr, nullptr, nullptr, &J);
    const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> mapped(
        J.num_rows, J.num_cols, static_cast<Eigen::Index>(J.values.size()), J.rows.data(), J.cols.data(),
        J.values.data());
    const SparseMatrix columns = mapped;
    return SparseMatrix(columns.transpose()) * columns;
  }

  std::unique_ptr<ceres::LossFunction> robust;
  std::unique_ptr<ceres::Problem> problem;
  Eigen::Vector3d sigma, sensor_sigma;
  std::deque<std::array<double, 3>> poses;  // x, y, heading; a deque: addresses stay
  std::vector<Utime> utimes;
  struct Said {
    Eigen::Vector2d position;
    double weight;
  };
  std::vector<Said> said;  // by the filter, of each pose
  std::map<std::int32_t, std::array<double, 2>> landmarks;
  std::map<std::int32_t, std::vector<ceres::ResidualBlockId>> sights;
  CalibrationMean calibration = CalibrationMean::Zero();
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();
  // Since the newest pose: steps without a sight make one motion.
  Eigen::Isometry3d T_pose_now = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();
  Jacobian63 jacobian = Jacobian63::Zero();
  std::size_t residuals = 0;
};

PathSmoother::PathSmoother(const FastSlamSettings& settings) : graph_(std::make_unique<Graph>(settings)) {}
PathSmoother::~PathSmoother() = default;

void PathSmoother::add(Utime utime, const Motion& motion, const Jacobian63& calibration_jacobian,
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
    g.problem->AddResidualBlock(new ceres::AutoDiffCostFunction<OdometryError, 3, 3, 3, 3>(error), nullptr,
                                before, g.poses.back().data(), g.calibration.data());
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
    g.sights[m.landmark_id].push_back(g.problem->AddResidualBlock(
        new ceres::AutoDiffCostFunction<LandmarkError, 2, 3, 2, 3>(error), g.robust.get(),
        g.poses.back().data(), landmark->second.data(), g.sensor.data()));
    ++g.residuals;
  }
}

void PathSmoother::forget(std::int32_t landmark_id) {
  Graph& g = *graph_;
  const auto landmark = g.landmarks.find(landmark_id);
  if (landmark == g.landmarks.end()) return;
  g.residuals -= g.sights[landmark_id].size();
  g.problem->RemoveParameterBlock(landmark->second.data());  // and its residuals
  g.sights.erase(landmark_id);
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
  g.place_world();
  return summary.final_cost / static_cast<double>(g.residuals);
}

std::vector<SmoothedPose> PathSmoother::path() const {
  std::vector<SmoothedPose> path;
  for (std::size_t i = 0; i < graph_->poses.size(); ++i) path.push_back({graph_->utimes[i], graph_->pose(i)});
  return path;
}

const CalibrationMean& PathSmoother::calibration() const {
  return graph_->calibration;
}

SensorCalibration PathSmoother::sensor() const {
  return {graph_->sensor.x(), graph_->sensor.y(), graph_->sensor.z()};
}

std::map<std::int32_t, LandmarkGaussian> PathSmoother::landmarks() const {
  Graph& g = *graph_;
  std::map<std::int32_t, LandmarkGaussian> result;
  if (g.poses.size() < 2) return result;
  const SparseMatrix H = g.information();
  const Eigen::SimplicialLLT<SparseMatrix> root(H);
  if (root.info() != Eigen::Success) return result;
  auto column = static_cast<Eigen::Index>(3 * (g.poses.size() - 1));
  for (const auto& [id, landmark] : g.landmarks) {
    LandmarkGaussian gaussian;
    gaussian.mean << landmark[0], landmark[1], 0;
    gaussian.covariance = kPlaneVariance * Eigen::Matrix3d::Identity();
    for (int i = 0; i < 2; ++i) {
      const Eigen::VectorXd unit = Eigen::VectorXd::Unit(H.rows(), column + i);
      gaussian.covariance.col(i).head<2>() = root.solve(unit).segment<2>(column);
    }
    result[id] = gaussian;
    column += 2;
  }
  return result;
}

std::vector<PathSample> PathSmoother::sample(std::size_t count, Random& random,
                                             Eigen::Matrix3d& calibration_covariance) {
  Graph& g = *graph_;
  std::vector<PathSample> samples;
  if (g.poses.size() < 2 || g.residuals == 0) return samples;
  const SparseMatrix H_all = g.information(true);
  const SparseMatrix H = H_all.topLeftCorner(H_all.rows() - 3, H_all.cols() - 3);
  const Eigen::SimplicialLLT<SparseMatrix> root(H);  // P H P^T = L L^T
  if (root.info() != Eigen::Success) return samples;
  const Eigen::Matrix3d sensor_root = g.sensor_root(H_all, root);

  const auto of_landmarks = static_cast<Eigen::Index>(3 * (g.poses.size() - 1));
  const Eigen::Index of_calibration = H.rows() - 3;
  const Eigen::Matrix3d given_path = Eigen::Matrix3d(H.block(of_calibration, of_calibration, 3, 3));
  calibration_covariance = given_path.llt().solve(Eigen::Matrix3d::Identity());
  const Eigen::Matrix3d Q = g.reduce(g.covariance);
  const Eigen::Matrix3d Q_root = (Q + 1e-12 * Eigen::Matrix3d::Identity()).llt().matrixL();
  for (std::size_t k = 0; k < count; ++k) {
    Eigen::VectorXd normal = Eigen::VectorXd::Zero(H.rows());
    for (Eigen::Index i = 0; i < normal.size() && k > 0; ++i) normal(i) = random.normal();
    const Eigen::VectorXd delta = root.permutationPinv() * root.matrixU().solve(normal).eval();
    Eigen::VectorXd path_only = delta;
    path_only.tail(H.rows() - of_landmarks).setZero();
    const Eigen::VectorXd pull = H * path_only;  // H_bp delta_p for each block b
    // The draw in the same world as the mode: the first pose is held, but the world is the whole path's.
    const Eigen::Isometry3d T_world_draw = g.fit(
        [&](std::size_t i) -> Eigen::Vector2d {
          const auto column_of = static_cast<Eigen::Index>(3 * i) - 3;
          return i == 0 ? g.position(i) : Eigen::Vector2d(g.position(i) + delta.segment<2>(column_of));
        },
        [&](std::size_t i) { return g.position(i); });
    // Mean of a block given the path: x* - H_bb^-1 H_bp delta_p.
    PathSample sample;
    auto column = of_landmarks;
    for (const auto& [id, landmark] : g.landmarks) {
      const Eigen::Matrix2d block = Eigen::Matrix2d(H.block(column, column, 2, 2));
      const Eigen::Matrix2d covariance = block.llt().solve(Eigen::Matrix2d::Identity());
      const Eigen::Vector2d shift = -covariance * pull.segment<2>(column);
      LandmarkGaussian& gaussian = sample.landmarks[id];
      gaussian.mean = T_world_draw * Eigen::Vector3d(landmark[0] + shift.x(), landmark[1] + shift.y(), 0);
      gaussian.covariance = kPlaneVariance * Eigen::Matrix3d::Identity();
      const Eigen::Matrix2d R = T_world_draw.linear().topLeftCorner<2, 2>();
      const Eigen::Matrix2d turned = R * covariance * R.transpose();
      gaussian.covariance.topLeftCorner<2, 2>() = 0.5 * (turned + turned.transpose());
      column += 2;
    }
    sample.calibration = g.calibration - calibration_covariance * pull.segment<3>(of_calibration);
    const auto& last = g.poses.back();
    const Eigen::Vector3d moved = delta.segment<3>(of_landmarks - 3);
    Eigen::Vector3d noise = Eigen::Vector3d::Zero();
    if (k > 0) noise = Q_root * standard_normal(random);
    Vector6d correction = g.jacobian * sample.calibration;
    for (int i = 0; i < 3; ++i) correction(PoseSpace<3>::row(i)) += noise(i);
    const Eigen::Isometry3d T_draw_last =
        planar_pose(last[0] + moved.x(), last[1] + moved.y(), last[2] + moved.z());
    sample.T_world_robot = T_world_draw * T_draw_last * g.T_pose_now *
                           se3_exp(PoseSpace<3>::expand(PoseSpace<3>::reduce(correction)));
    // The calibration that all samples share may be wrong: as if the path had begun elsewhere.
    if (k > 0 && g.sensor_sigma.maxCoeff() > 1e-9)
      noise = sensor_root * standard_normal(random);
    else
      noise.setZero();
    const Eigen::Isometry3d T_otherwise_last = planar_pose(
        last[0] + moved.x() + noise.x(), last[1] + moved.y() + noise.y(), last[2] + moved.z() + noise.z());
    sample.T_world_start = T_world_draw * T_draw_last * T_otherwise_last.inverse() * g.pose(0);
    samples.push_back(std::move(sample));
  }
  return samples;
}

}  // namespace lcmslam
