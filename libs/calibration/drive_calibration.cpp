#include <lcmslam/calibration/drive_calibration.hpp>

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>

#include <lcmslam/calibration/moved_pose.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t fewest_stretches = 10;

/// Motion of the body over a stretch, (x, y, heading) on exact arcs.
template <class T>
Eigen::Matrix<T, 3, 1> body_motion(const std::vector<WheelStep>& steps, const T* radii, const T& layout) {
  using std::cos;
  using std::sin;
  T x(0), y(0), heading(0);
  for (const WheelStep& step : steps) {
    T motion[3] = {T(0), T(0), T(0)};
    for (Eigen::Index i = 0; i < step.by_wheel.cols(); ++i)
      for (int k = 0; k < 3; ++k) motion[k] += step.by_wheel(k, i) * radii[i];
    // The wheels' places scale the turn, and nothing else.
    const T turn = motion[2] / layout, middle = heading + 0.5 * turn;
    x += cos(middle) * motion[0] - sin(middle) * motion[1];
    y += sin(middle) * motion[0] + cos(middle) * motion[1];
    heading += turn;
  }
  return {x, y, heading};
}

/// A^-1 X B X^-1 should be the identity; whitened. The camera's height is taken as given: what turns about
/// the vertical says of it is noise alone, which adds up and looks like knowledge.
struct StretchError {
  const Stretch& stretch;
  Eigen::Isometry3d start;
  double height;  // m
  Matrix6d whitening;

  template <class T>
  bool operator()(T const* const* p, T* residual) const {
    const Eigen::Matrix<T, 3, 1> body = body_motion(stretch.steps, p[1], *p[2]);
    const MovedPose<T> X(start, p[0]);
    const Eigen::Matrix<T, 3, 3> RB = stretch.T_from_to.linear().cast<T>();
    const Eigen::Matrix<T, 3, 1> tB = stretch.T_from_to.translation().cast<T>();
    const Eigen::Matrix<T, 3, 1> place(X.t.x(), X.t.y(), T(height));
    // X B X^-1
    const Eigen::Matrix<T, 3, 3> R = X.R * RB * X.R.transpose();
    const Eigen::Matrix<T, 3, 1> t = X.R * tB + place - R * place;
    // A^-1 of it
    using std::cos;
    using std::sin;
    const T c = cos(body[2]), s = sin(body[2]);
    Eigen::Matrix<T, 3, 3> back;
    back << c, s, T(0), -s, c, T(0), T(0), T(0), T(1);
    const Eigen::Matrix<T, 3, 3> left = back * R;
    Eigen::Matrix<T, 6, 1> error;
    error.template head<3>() = back * (t - Eigen::Matrix<T, 3, 1>(body[0], body[1], T(0)));
    Eigen::Matrix<T, 3, 3> rotation = left;  // column-major
    ceres::RotationMatrixToAngleAxis(rotation.data(), error.data() + 3);
    Eigen::Map<Eigen::Matrix<T, 6, 1>>{residual} = whitening.cast<T>() * error;
    return true;
  }
};

/// The floor is the plane z = 0 of the robot.
struct FloorError {
  FloorSight floor;
  Eigen::Isometry3d start;
  template <class T>
  bool operator()(const T* mount, T* residual) const {
    const MovedPose<T> X(start, mount);
    const Eigen::Matrix<T, 3, 1> up = X.R * floor.up.cast<T>();
    residual[0] = up.x() / floor.up_sigma;
    residual[1] = up.y() / floor.up_sigma;
    residual[2] = (X.t.z() - floor.height) / floor.height_sigma;
    return true;
  }
};

struct FactorPrior {
  double sigma;
  template <class T>
  bool operator()(const T* factor, T* residual) const {
    *residual = (*factor - 1.0) / sigma;
    return true;
  }
};

struct FactorsPrior {
  double sigma;
  std::size_t count;
  template <class T>
  bool operator()(T const* const* p, T* residual) const {
    for (std::size_t i = 0; i < count; ++i) residual[i] = (p[0][i] - 1.0) / sigma;
    return true;
  }
};

/// Wheels' noise, in the robot's frame, and the camera's, brought there by the start.
Matrix6d covariance_of(const Stretch& stretch, const Eigen::Isometry3d& start,
                       const DriveCalibrationSettings& settings) {
  double way = 0;
  for (const WheelStep& step : stretch.steps) way += step.way;
  const auto variance = [](double sigma) { return sigma * sigma; };
  const double quantum = variance(settings.quantum), flat = variance(settings.flatness);
  const bool one_axle = stretch.steps.front().by_wheel.cols() == 2;
  const double along = variance(settings.translation_drift) * way + quantum;
  const double across = variance(one_axle ? settings.side_drift : settings.translation_drift) * way + quantum;
  const double turn =
      variance(settings.rotation_drift) * way + quantum / variance(0.3);  // wheels' distance, m
  Matrix6d sum = adjoint(start) * stretch.covariance * adjoint(start).transpose();
  sum.diagonal() += (Vector6d() << along, across, flat, flat, flat, turn).finished();
  // A heading that walks away over the stretch has moved its end, too: y is the integral of the heading.
  sum(1, 1) += turn * way * way / 3;
  sum(1, 5) += turn * way / 2;
  sum(5, 1) += turn * way / 2;
  return 0.5 * (sum + sum.transpose());
}

class DriveProblem {
 public:
  DriveProblem(const std::vector<Stretch>& stretches, const std::optional<FloorSight>& floor,
               const Eigen::Isometry3d& start, const DriveCalibrationSettings& settings)
      : wheels_(static_cast<std::size_t>(stretches.front().steps.front().by_wheel.cols())),
        start_(start),
        height_(floor ? floor->height : start.translation().z()),
        settings_(settings),
        radii(wheels_, 1.0) {
    for (const Stretch& stretch : stretches) add(stretch);
    auto* prior = new ceres::DynamicAutoDiffCostFunction<FactorsPrior, 8>(
        new FactorsPrior{settings.factor_sigma, wheels_});
    prior->AddParameterBlock(static_cast<int>(wheels_));
    prior->SetNumResiduals(static_cast<int>(wheels_));
    problem.AddResidualBlock(prior, nullptr, radii.data());
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<FactorPrior, 1, 1>(new FactorPrior{settings.factor_sigma}), nullptr,
        &layout);
    if (floor)
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<FloorError, 3, 6>(new FloorError{*floor, start}), nullptr,
          mount.data());
    else
      hold_height();
  }

  void solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = 100;
    options.function_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (!summary.IsSolutionUsable()) throw std::runtime_error("the drive: " + summary.message);
  }

  /// Squared residuals of each stretch, in variances.
  std::vector<double> squares() {
    std::vector<double> result;
    for (const auto& block : blocks_) {
      double cost = 0;
      problem.EvaluateResidualBlock(block, false, &cost, nullptr, nullptr);
      result.push_back(2 * cost);
    }
    return result;
  }

 private:
  void add(const Stretch& stretch) {
    if (stretch.steps.front().by_wheel.cols() != static_cast<Eigen::Index>(wheels_))
      throw std::invalid_argument("the number of wheels changes during the drive");
    const Matrix6d covariance = covariance_of(stretch, start_, settings_);
    const Eigen::LLT<Matrix6d> root(covariance);
    if (root.info() != Eigen::Success) return;  // the camera's pose jumped: it says nothing
    const Matrix6d whitening = root.matrixL().solve(Matrix6d::Identity());
    auto* error = new ceres::DynamicAutoDiffCostFunction<StretchError, 8>(
        new StretchError{stretch, start_, height_, whitening});
    error->AddParameterBlock(6);
    error->AddParameterBlock(static_cast<int>(wheels_));
    error->AddParameterBlock(1);
    error->SetNumResiduals(6);
    blocks_.push_back(problem.AddResidualBlock(error,
                                               new ceres::CauchyLoss(settings_.kernel * std::sqrt(6.0)),
                                               mount.data(), radii.data(), &layout));
  }

  /// The step is in the camera's frame: the robot's vertical is one direction of it that stays.
  void hold_height() {
    const Eigen::Vector3d up = start_.linear().transpose() * Eigen::Vector3d::UnitZ();
    auto* hold = new ceres::DynamicAutoDiffCostFunction<HeightError, 6>(new HeightError{up});
    hold->AddParameterBlock(6);
    hold->SetNumResiduals(1);
    problem.AddResidualBlock(hold, nullptr, mount.data());
  }
  struct HeightError {
    Eigen::Vector3d up;
    template <class T>
    bool operator()(T const* const* p, T* residual) const {
      constexpr double sigma = 1e-4;  // m
      residual[0] = (up.x() * p[0][0] + up.y() * p[0][1] + up.z() * p[0][2]) / sigma;
      return true;
    }
  };

  std::size_t wheels_;
  Eigen::Isometry3d start_;
  double height_;
  DriveCalibrationSettings settings_;
  std::vector<ceres::ResidualBlockId> blocks_;

 public:
  ceres::Problem problem;
  PoseStep mount{};
  std::vector<double> radii;
  double layout = 1;
};

void take_covariances(DriveProblem& p, DriveCalibration& result) {
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::DENSE_SVD;
  options.null_space_rank = -1;
  ceres::Covariance covariance(options);
  const double *mount = p.mount.data(), *radii = p.radii.data(), *layout = &p.layout;
  if (!covariance.Compute({{mount, mount}, {radii, radii}, {radii, layout}, {layout, layout}}, &p.problem))
    throw std::runtime_error("the drive does not tell: drive straight ways and turns to both sides");
  const auto n = static_cast<Eigen::Index>(p.radii.size());
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> pose;
  covariance.GetCovarianceBlock(mount, mount, pose.data());
  result.covariance = pose;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> of_radii(n, n);
  Eigen::VectorXd cross(n);
  covariance.GetCovarianceBlock(radii, radii, of_radii.data());
  covariance.GetCovarianceBlock(radii, layout, cross.data());
  result.factor_covariance.resize(n + 1, n + 1);
  result.factor_covariance.topLeftCorner(n, n) = of_radii;
  result.factor_covariance.topRightCorner(n, 1) = cross;
  result.factor_covariance.bottomLeftCorner(1, n) = cross.transpose();
  covariance.GetCovarianceBlock(layout, layout, &result.factor_covariance(n, n));
  // Where residuals are larger than the noise that was taken for granted, everything is less sure.
  const double inflation = std::max(1.0, result.misfit * result.misfit);
  result.covariance *= inflation;
  result.factor_covariance *= inflation;
  // What the solver held was measured by nobody: it is the start's, which may have none.
  if (result.height_observed) return;
  constexpr double unknown_height = 1;  // m
  const Eigen::Vector3d up = unknown_height * result.T_robot_camera.linear().transpose().col(2);
  result.covariance.topLeftCorner<3, 3>() += up * up.transpose();
}

}  // namespace

Vector6d DriveCalibration::robot_sigmas() const {
  const Eigen::Matrix3d R = T_robot_camera.linear();
  Vector6d sigmas;
  sigmas.head<3>() = (R * covariance.topLeftCorner<3, 3>() * R.transpose()).diagonal().cwiseSqrt();
  sigmas.tail<3>() = (R * covariance.bottomRightCorner<3, 3>() * R.transpose()).diagonal().cwiseSqrt();
  return sigmas;
}

DriveCalibration calibrate_drive(const std::vector<Stretch>& stretches,
                                 const std::optional<FloorSight>& floor, const Eigen::Isometry3d& start,
                                 const DriveCalibrationSettings& settings) {
  if (stretches.size() < fewest_stretches)
    throw std::invalid_argument(
        "the drive has " + std::to_string(stretches.size()) +
        " stretches in which the camera was tracked and wheels were heard; at least ten are "
        "needed: drive a figure of eight, slowly, before things that are rich in texture");
  DriveProblem rough(stretches, floor, start, settings);
  rough.solve();
  // Once more from there: the camera's noise is turned into the robot's frame by where the problem begins,
  // and a step's covariance is the pose's where the step is small.
  const Eigen::Isometry3d near = moved(start, rough.mount);
  DriveProblem problem(stretches, floor, near, settings);
  problem.solve();
  DriveCalibration result;
  result.T_robot_camera = moved(near, problem.mount);
  result.height_observed = floor.has_value();
  result.radius_factors = problem.radii;
  result.layout_factor = problem.layout;
  result.stretches = static_cast<int>(stretches.size());
  double sum = 0;
  int agreeing = 0;
  for (const double squares : problem.squares()) {
    if (squares > 6 * settings.kernel * settings.kernel) {
      ++result.slips;
      continue;
    }
    sum += squares / 6;
    ++agreeing;
  }
  result.misfit = std::sqrt(sum / std::max(1, agreeing));
  for (const Stretch& stretch : stretches) {
    for (const WheelStep& step : stretch.steps) result.way += step.way;
    result.turned += rotation_angle(stretch.T_from_to);
  }
  take_covariances(problem, result);
  if (agreeing == 0 || !result.covariance.allFinite() || !result.factor_covariance.allFinite())
    throw std::runtime_error(
        "wheels and camera tell no common motion: do the log's images and wheels have one clock?");
  return result;
}

}  // namespace lcmslam
