#include <lcmslam/geometry/rigid_alignment.hpp>

#include <Eigen/Dense>
#include <cmath>

namespace lcmslam {
namespace {

AlignmentStatus check_input(const std::vector<Eigen::Vector3d>& source,
                            const std::vector<Eigen::Vector3d>& target, const std::vector<double>& weights) {
  const std::size_t n = source.size();
  if (target.size() != n || (!weights.empty() && weights.size() != n)) return AlignmentStatus::bad_input;
  std::size_t used = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double w = weights.empty() ? 1.0 : weights[i];
    if (!source[i].allFinite() || !target[i].allFinite() || !std::isfinite(w) || w < 0)
      return AlignmentStatus::bad_input;
    if (w > 0) ++used;
  }
  return used < 3 ? AlignmentStatus::too_few : AlignmentStatus::ok;
}

// Spreads are compared with the points' distance from the origin, below which rounding rules.
AlignmentStatus check_shape(const PairMoments& m, double source_square, double target_square,
                            double target_spread) {
  constexpr double rounding = 1e-24;
  if (!(m.source_spread.trace() > rounding * source_square) || !(target_spread > rounding * target_square))
    return AlignmentStatus::coincident;
  const Eigen::Vector3d d = m.cross.jacobiSvd().singularValues();
  return d(1) > 1e-9 * d(0) ? AlignmentStatus::ok : AlignmentStatus::collinear;
}

}  // namespace

std::string to_string(AlignmentStatus status) {
  switch (status) {
    case AlignmentStatus::ok:
      return "ok";
    case AlignmentStatus::bad_input:
      return "bad input";
    case AlignmentStatus::too_few:
      return "too few pairs";
    case AlignmentStatus::coincident:
      return "coincident points";
    case AlignmentStatus::collinear:
      return "collinear points";
  }
  return "unknown";
}

RigidAlignment RigidEstimator::estimate(const std::vector<Eigen::Vector3d>& source,
                                        const std::vector<Eigen::Vector3d>& target,
                                        const std::vector<double>& weights) const {
  RigidAlignment result;
  result.status = check_input(source, target, weights);
  if (!result) return result;

  PairMoments m;
  m.source_mean.setZero();
  m.target_mean.setZero();
  double source_square = 0;
  double target_square = 0;
  const auto weight = [&](std::size_t i) { return weights.empty() ? 1.0 : weights[i]; };
  for (std::size_t i = 0; i < source.size(); ++i) {
    m.total += weight(i);
    m.source_mean += weight(i) * source[i];
    m.target_mean += weight(i) * target[i];
    source_square += weight(i) * source[i].squaredNorm();
    target_square += weight(i) * target[i].squaredNorm();
  }
  m.source_mean /= m.total;
  m.target_mean /= m.total;

  m.cross.setZero();
  m.source_spread.setZero();
  double target_spread = 0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Eigen::Vector3d p = source[i] - m.source_mean;
    const Eigen::Vector3d q = target[i] - m.target_mean;
    m.cross += weight(i) * p * q.transpose();
    m.source_spread += weight(i) * p * p.transpose();
    target_spread += weight(i) * q.squaredNorm();
  }
  result.status = check_shape(m, source_square, target_square, target_spread);
  if (!result) return result;

  const Eigen::Matrix3d R = rotation(m);
  result.T_target_source.linear() = R;
  result.T_target_source.translation() = m.target_mean - R * m.source_mean;
  return result;
}

Eigen::Matrix3d SvdEstimator::rotation(const PairMoments& moments) const {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(moments.cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const bool reflection = (svd.matrixV() * svd.matrixU().transpose()).determinant() < 0;
  const Eigen::Vector3d sign(1, 1, correct_reflection_ && reflection ? -1 : 1);
  return svd.matrixV() * sign.asDiagonal() * svd.matrixU().transpose();
}

Eigen::Matrix3d QuaternionEstimator::rotation(const PairMoments& moments) const {
  const Eigen::Matrix3d& S = moments.cross;
  const double sign = form_ == Form::corrected ? -1 : 1;
  const Eigen::Vector3d v(S(1, 2) + sign * S(2, 1), S(2, 0) + sign * S(0, 2), S(0, 1) + sign * S(1, 0));
  Eigen::Matrix4d N;
  N(0, 0) = S.trace();
  N.block<1, 3>(0, 1) = v.transpose();
  N.block<3, 1>(1, 0) = v;
  N.block<3, 3>(1, 1) = S + S.transpose() - S.trace() * Eigen::Matrix3d::Identity();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(N);
  const Eigen::Vector4d q = eigen.eigenvectors().col(3);  // eigenvalues ascend
  return Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized().toRotationMatrix();
}

Eigen::Matrix3d SmallAngleEstimator::rotation(const PairMoments& moments) const {
  // Normal equations: sum w (|p'|^2 I - p' p'^T) omega = sum w p' x q'.
  const Eigen::Matrix3d& P = moments.source_spread;
  const Eigen::Matrix3d& S = moments.cross;
  const Eigen::Matrix3d A = P.trace() * Eigen::Matrix3d::Identity() - P;
  const Eigen::Vector3d b(S(1, 2) - S(2, 1), S(2, 0) - S(0, 2), S(0, 1) - S(1, 0));
  const Eigen::Vector3d omega = A.ldlt().solve(b);
  if (form_ == Form::as_printed) return Eigen::Matrix3d::Identity() + hat(omega);
  return (Eigen::AngleAxisd(omega.z(), Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(omega.y(), Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(omega.x(), Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

std::optional<Eigen::Isometry3d> align_svd(const std::vector<Eigen::Vector3d>& source,
                                           const std::vector<Eigen::Vector3d>& target,
                                           const std::vector<double>& weights) {
  const RigidAlignment result = SvdEstimator().estimate(source, target, weights);
  if (!result) return std::nullopt;
  return result.T_target_source;
}

}  // namespace lcmslam
