#include <Eigen/Dense>
#include <algorithm>

#include <lcmslam/registration/solver.hpp>

namespace lcmslam {
namespace {

// xi = basis * y: y is about the centroid, rotations in metres at the RMS spread.
Matrix6d centred_basis(const std::vector<Pair>& pairs) {
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  double weight = 0;
  for (const Pair& p : pairs) {
    centroid += p.weight * p.source;
    weight += p.weight;
  }
  centroid /= weight;
  double spread = 0;
  for (const Pair& p : pairs) spread += p.weight * (p.source - centroid).squaredNorm();
  const double length = std::max(std::sqrt(spread / weight), 1e-3);
  Matrix6d basis = adjoint(Eigen::Isometry3d(Eigen::Translation3d(centroid)));
  basis.rightCols<3>() /= length;
  return basis;
}

// Of what the weights count with, as they count it: m^2.
double assumed_variance(const std::vector<Pair>& pairs) {
  double sum = 0, weight = 0;
  for (const Pair& p : pairs) {
    sum += p.weight * p.variance;
    weight += p.weight;
  }
  return sum / weight;
}

}  // namespace

Observability observe(const std::vector<Pair>& pairs, const Metric& metric,
                      const Eigen::Isometry3d& T_target_source, const RegistrationSettings& settings) {
  Observability result;
  NormalEquations equations;
  for (const Pair& p : pairs) metric.add(p, T_target_source.linear(), equations);
  if (!(equations.weight > 0) || !equations.H.allFinite()) {
    result.degenerate = {0, 1, 2, 3, 4, 5};
    return result;
  }

  result.basis = centred_basis(pairs);
  const Matrix6d H = result.basis.transpose() * equations.H * result.basis;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(H);
  result.directions = eigen.eigenvectors();
  result.shares = eigen.eigenvalues() / equations.weight;

  // Unweighted pairs have no assumed noise: the residuals tell it. Noise that was assumed is not believed
  // away; what pairs err by beyond it is doubt of where they lead, but no reason to hold them back on the
  // way.
  const double residual = equations.squared_error / equations.weight;
  const double variance = settings.weigh_by_noise ? 1.0 : std::max(1e-8, residual);
  if (settings.weigh_by_noise) result.excess = std::max(1.0, residual / assumed_variance(pairs));
  const double independent = std::min(1.0, settings.independent_pairs / static_cast<double>(pairs.size()));
  result.scale = independent / variance;

  const Vector6d b = result.directions.transpose() * result.basis.transpose() * equations.b;
  for (int i = 0; i < 6; ++i) {
    if (result.shares(i) < settings.degenerate_share) {
      result.degenerate.push_back(i);
      continue;
    }
    const Vector6d v = result.directions.col(i);
    result.information += result.scale * eigen.eigenvalues()(i) * v * v.transpose();
    result.gradient += result.scale * b(i) * v;
  }
  return result;
}

std::vector<Vector6d> Observability::degenerate_twists() const {
  std::vector<Vector6d> twists;
  for (const int i : degenerate) twists.push_back((basis * directions.col(i)).normalized());
  return twists;
}

Matrix6d Observability::covariance(const Prior* prior) const {
  Matrix6d total = information / excess;
  if (prior) total += basis.transpose() * prior->information * basis;
  if (!prior)
    for (const int i : degenerate) total += directions.col(i) * directions.col(i).transpose();
  const Matrix6d inverse = total.ldlt().solve(Matrix6d::Identity());
  const Matrix6d covariance = basis * inverse * basis.transpose();
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace lcmslam
