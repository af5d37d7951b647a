#pragma once
// From weighted pairs to the next transform.

#include <memory>
#include <optional>

#include <lcmslam/geometry/rigid_alignment.hpp>
#include <lcmslam/registration/metric.hpp>

namespace lcmslam {

/// What is known before registration: T_target_source with the information (inverse covariance,
/// right perturbation) of that knowledge.
struct Prior {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  Matrix6d information = Matrix6d::Zero();
};

class Solver {
 public:
  virtual ~Solver() = default;
  /// The transform after one step from T_target_source; nothing when the pairs do not give one.
  virtual std::optional<Eigen::Isometry3d> solve(const std::vector<Pair>& pairs,
                                                 const Eigen::Isometry3d& T_target_source) const = 0;
};

/// Closed-form minimum over the moved points; point-to-point only.
class ClosedFormSolver : public Solver {
 public:
  explicit ClosedFormSolver(std::unique_ptr<RigidEstimator> estimator) : estimator_(std::move(estimator)) {}
  std::optional<Eigen::Isometry3d> solve(const std::vector<Pair>& pairs,
                                         const Eigen::Isometry3d& T_target_source) const override;

 private:
  std::unique_ptr<RigidEstimator> estimator_;
};

/// What the pairs say about T_target_source at a point, direction by direction.
///
/// The six coordinates y are taken about the centroid of the source points, rotations times their
/// RMS spread: xi = basis * y. That makes translations and rotations comparable. A direction whose
/// eigenvalue is below `degenerate_share` of the total weight is degenerate (Zhang, Kaess and Singh
/// 2016) and its information is left out as noise.
struct Observability {
  Matrix6d basis = Matrix6d::Identity();
  Matrix6d directions = Matrix6d::Identity();  ///< columns: eigenvectors in y
  Vector6d shares = Vector6d::Zero();          ///< eigenvalue / weight, ascending
  std::vector<int> degenerate;                 ///< columns of `directions`
  double scale = 0;                            ///< that scaling
  double excess = 1;                        ///< mean squared residual over the assumed variance; at least 1
  Matrix6d information = Matrix6d::Zero();  ///< in y, of assumed (else: seen) noise, degenerate ones out
  Vector6d gradient = Vector6d::Zero();     ///< in y, scaled alike: information * y = gradient

  /// Degenerate directions as unit twists (translation, rotation) of the source frame.
  std::vector<Vector6d> degenerate_twists() const;
  /// Covariance of T_target_source (right perturbation), with the prior if there is one and as much more
  /// noise as the residuals have than was assumed. Directions that nothing fixes get a standard deviation of
  /// 1 m (rotations: at the points' RMS spread).
  Matrix6d covariance(const Prior* prior) const;
};

Observability observe(const std::vector<Pair>& pairs, const Metric& metric,
                      const Eigen::Isometry3d& T_target_source, const RegistrationSettings& settings);

/// Gauss-Newton on SE(3). With a prior, degenerate directions follow it; without, they stay.
class GaussNewtonSolver : public Solver {
 public:
  GaussNewtonSolver(const RegistrationSettings& settings, const Prior* prior)
      : settings_(settings), metric_(make_metric(settings)), prior_(prior) {}
  std::optional<Eigen::Isometry3d> solve(const std::vector<Pair>& pairs,
                                         const Eigen::Isometry3d& T_target_source) const override;

 private:
  RegistrationSettings settings_;
  std::unique_ptr<Metric> metric_;
  const Prior* prior_;
};

/// The same step, shortened until the pairs' cost falls (Levenberg 1944, Marquardt 1963).
class LevenbergMarquardtSolver : public Solver {
 public:
  LevenbergMarquardtSolver(const RegistrationSettings& settings, const Prior* prior)
      : settings_(settings), metric_(make_metric(settings)), prior_(prior) {}
  std::optional<Eigen::Isometry3d> solve(const std::vector<Pair>& pairs,
                                         const Eigen::Isometry3d& T_target_source) const override;

 private:
  double cost(const std::vector<Pair>& pairs, const Eigen::Isometry3d& T, double scale) const;

  RegistrationSettings settings_;
  std::unique_ptr<Metric> metric_;
  const Prior* prior_;
};

/// Throws std::invalid_argument for combinations that do not exist (a closed form for
/// point-to-plane, or with a prior). The prior must outlive the solver.
std::unique_ptr<Solver> make_solver(const RegistrationSettings& settings, const Prior* prior);

}  // namespace lcmslam
