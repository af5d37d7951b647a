#include <lcmslam/registration/solver.hpp>

#include <Eigen/Dense>
#include <stdexcept>

namespace lcmslam {
namespace {

std::unique_ptr<RigidEstimator> make_estimator(SolverKind kind) {
  switch (kind) {
    case SolverKind::svd:
      return std::make_unique<SvdEstimator>();
    case SolverKind::svd_uncorrected:
      return std::make_unique<SvdEstimator>(false);
    case SolverKind::quaternion:
      return std::make_unique<QuaternionEstimator>();
    case SolverKind::quaternion_as_printed:
      return std::make_unique<QuaternionEstimator>(QuaternionEstimator::Form::as_printed);
    case SolverKind::small_angle:
      return std::make_unique<SmallAngleEstimator>();
    case SolverKind::small_angle_as_printed:
      return std::make_unique<SmallAngleEstimator>(SmallAngleEstimator::Form::as_printed);
    case SolverKind::gauss_newton:
    case SolverKind::levenberg_marquardt:
      break;
  }
  return nullptr;
}

/// Minimises |J xi + r|^2 + |xi + e|^2 under the prior's information, e = log(T_prior^-1 T). The prior's
/// Jacobian is taken as identity: its error is of second order in e.
class Step {
 public:
  Step(const Observability& seen, const Eigen::Isometry3d& T, const Prior* prior)
      : basis_(seen.basis), A_(seen.information), b_(seen.gradient) {
    if (prior) {
      const Vector6d e = se3_log(prior->T_target_source.inverse() * T);
      A_ += basis_.transpose() * prior->information * basis_;
      b_ -= basis_.transpose() * prior->information * e;
    } else {
      for (const int i : seen.degenerate) A_ += seen.directions.col(i) * seen.directions.col(i).transpose();
    }
  }

  /// With so much of A's diagonal added to it; nothing when that cannot be solved.
  std::optional<Eigen::Isometry3d> from(const Eigen::Isometry3d& T, double damping) const {
    Matrix6d A = A_;
    A.diagonal() *= 1 + damping;
    const Vector6d xi = basis_ * A.ldlt().solve(b_);
    if (!xi.allFinite()) return std::nullopt;
    return T * se3_exp(xi);
  }

 private:
  Matrix6d basis_, A_;
  Vector6d b_;
};

}  // namespace

std::optional<Eigen::Isometry3d> ClosedFormSolver::solve(const std::vector<Pair>& pairs,
                                                         const Eigen::Isometry3d& T_target_source) const {
  std::vector<Eigen::Vector3d> moved, target;
  std::vector<double> weights;
  for (const Pair& p : pairs) {
    moved.push_back(p.moved);
    target.push_back(p.target);
    weights.push_back(p.weight);
  }
  const RigidAlignment step = estimator_->estimate(moved, target, weights);
  if (!step) return std::nullopt;
  return step.T_target_source * T_target_source;
}

std::optional<Eigen::Isometry3d> GaussNewtonSolver::solve(const std::vector<Pair>& pairs,
                                                          const Eigen::Isometry3d& T_target_source) const {
  const Observability seen = observe(pairs, *metric_, T_target_source, settings_);
  if (!prior_ && seen.degenerate.size() == 6) return std::nullopt;
  const Step step(seen, T_target_source, prior_);
  return step.from(T_target_source, 0);
}

std::optional<Eigen::Isometry3d> LevenbergMarquardtSolver::solve(
    const std::vector<Pair>& pairs, const Eigen::Isometry3d& T_target_source) const {
  const Observability seen = observe(pairs, *metric_, T_target_source, settings_);
  if (!prior_ && seen.degenerate.size() == 6) return std::nullopt;
  const Step step(seen, T_target_source, prior_);
  const double here = cost(pairs, T_target_source, seen.scale);
  for (const double damping : {1e-6, 1e-3, 1e-2, 1e-1, 1., 10., 100.}) {
    const auto T = step.from(T_target_source, damping);
    if (T && cost(pairs, *T, seen.scale) < here) return T;
  }
  return T_target_source;  // nothing is better: this is the minimum
}

// Of the same pairs elsewhere; what a metric derives from the source's normals is held fixed, as in add().
double LevenbergMarquardtSolver::cost(const std::vector<Pair>& pairs, const Eigen::Isometry3d& T,
                                      double scale) const {
  double sum = 0;
  for (Pair p : pairs) {
    p.moved = T * p.source;
    sum += p.weight * metric_->squared_error(p);
  }
  sum *= scale;
  if (prior_) {
    const Vector6d e = se3_log(prior_->T_target_source.inverse() * T);
    sum += e.dot(prior_->information * e);
  }
  return sum;
}

std::unique_ptr<Solver> make_solver(const RegistrationSettings& settings, const Prior* prior) {
  if (settings.solver == SolverKind::gauss_newton)
    return std::make_unique<GaussNewtonSolver>(settings, prior);
  if (settings.solver == SolverKind::levenberg_marquardt)
    return std::make_unique<LevenbergMarquardtSolver>(settings, prior);
  if (settings.metric != MetricKind::point_to_point || settings.colour_scale > 0)
    throw std::invalid_argument(
        "registration: closed-form estimators minimise point_to_point without colour only; "
        "the others need the solver gauss_newton or levenberg_marquardt");
  if (prior)
    throw std::invalid_argument(
        "registration: only the solvers gauss_newton and levenberg_marquardt take a prior");
  return std::make_unique<ClosedFormSolver>(make_estimator(settings.solver));
}

}  // namespace lcmslam
