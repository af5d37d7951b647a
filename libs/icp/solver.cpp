#include "icp/solver.hpp"

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
    case SolverKind::small_angle:
      return std::make_unique<SmallAngleEstimator>();
    case SolverKind::small_angle_as_printed:
      return std::make_unique<SmallAngleEstimator>(SmallAngleEstimator::Form::as_printed);
    case SolverKind::gauss_newton:
      break;
  }
  return nullptr;
}

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

// Minimises |J xi + r|^2 + |xi + e|^2 under the prior's information, e = log(T_prior^-1 T). The
// prior's Jacobian is taken as identity: its error is of second order in e.
std::optional<Eigen::Isometry3d> GaussNewtonSolver::solve(const std::vector<Pair>& pairs,
                                                          const Eigen::Isometry3d& T_target_source) const {
  const Observability seen = observe(pairs, *metric_, T_target_source, settings_);
  if (!prior_ && seen.degenerate.size() == 6) return std::nullopt;

  Matrix6d A = seen.information;
  Vector6d b = seen.gradient;
  if (prior_) {
    const Vector6d e = se3_log(prior_->T_target_source.inverse() * T_target_source);
    A += seen.basis.transpose() * prior_->information * seen.basis;
    b -= seen.basis.transpose() * prior_->information * e;
  } else {
    for (const int i : seen.degenerate) A += seen.directions.col(i) * seen.directions.col(i).transpose();
  }
  const Vector6d xi = seen.basis * A.ldlt().solve(b);
  if (!xi.allFinite()) return std::nullopt;
  return T_target_source * se3_exp(xi);
}

std::unique_ptr<Solver> make_solver(const RegistrationSettings& settings, const Prior* prior) {
  if (settings.solver == SolverKind::gauss_newton)
    return std::make_unique<GaussNewtonSolver>(settings, prior);
  if (settings.metric != MetricKind::point_to_point)
    throw std::invalid_argument(
        "registration: closed-form estimators minimise point_to_point only; "
        "point_to_plane needs the solver gauss_newton");
  if (prior) throw std::invalid_argument("registration: only the solver gauss_newton takes a prior");
  return std::make_unique<ClosedFormSolver>(make_estimator(settings.solver));
}

}  // namespace lcmslam
