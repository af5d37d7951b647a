#include "icp/metric.hpp"

namespace lcmslam {

double PointToPlane::squared_error(const Pair& pair) const {
  const double r = pair.target_normal.dot(pair.moved - pair.target);
  return r * r;
}

// d(T exp(xi) p) = R (v + omega x p), so J = [n_s^T, (p x n_s)^T] with n_s = R^T n.
void PointToPlane::add(const Pair& pair, const Eigen::Matrix3d& R, NormalEquations& equations) const {
  const double r = pair.target_normal.dot(pair.moved - pair.target);
  Vector6d J;
  J.head<3>() = R.transpose() * pair.target_normal;
  J.tail<3>() = pair.source.cross(J.head<3>());
  const Vector6d weighted = pair.weight * J;
  equations.H.noalias() += weighted * J.transpose();
  equations.b -= weighted * r;
  equations.squared_error += pair.weight * r * r;
  equations.weight += pair.weight;
}

double PointToPoint::squared_error(const Pair& pair) const {
  return pair.squared_distance();
}

// In source axes the residual is R^T (T p - q) and J = [I, -hat(p)].
void PointToPoint::add(const Pair& pair, const Eigen::Matrix3d& R, NormalEquations& equations) const {
  const Eigen::Vector3d r = R.transpose() * (pair.moved - pair.target);
  Eigen::Matrix<double, 3, 6> J;
  J.leftCols<3>().setIdentity();
  J.rightCols<3>() = -hat(pair.source);
  equations.H.noalias() += pair.weight * J.transpose() * J;
  equations.b.noalias() -= pair.weight * J.transpose() * r;
  equations.squared_error += pair.weight * r.squaredNorm();
  equations.weight += 3 * pair.weight;
}

std::unique_ptr<Metric> make_metric(MetricKind kind) {
  if (kind == MetricKind::point_to_point) return std::make_unique<PointToPoint>();
  return std::make_unique<PointToPlane>();
}

}  // namespace lcmslam
