#include <lcmslam/registration/metric.hpp>

#include <Eigen/LU>
#include <cmath>

namespace lcmslam {
namespace {

// A residual n^T (T p - q) + c: d(T exp(xi) p) = R (v + omega x p), so J = [n_s^T, (p x n_s)^T] with n_s =
// R^T n.
void add_row(const Pair& pair, const Eigen::Matrix3d& R, const Eigen::Vector3d& n, double r,
             NormalEquations& equations) {
  Vector6d J;
  J.head<3>().noalias() = R.transpose() * n;
  J.tail<3>() = pair.source.cross(J.head<3>());
  const Vector6d weighted = pair.weight * J;
  equations.H.noalias() += weighted * J.transpose();
  equations.b -= weighted * r;
  equations.squared_error += pair.weight * r * r;
}

Eigen::Matrix3d plane_information(const Pair& pair) {
  constexpr double e = 1e-3;
  const Eigen::Vector3d& n = pair.target_normal;
  const Eigen::Vector3d& m = pair.moved_normal;
  const Eigen::Matrix3d spread =
      2 * Eigen::Matrix3d::Identity() - (1 - e) * (n * n.transpose() + m * m.transpose());
  return 2 * e * spread.inverse();
}

double colour_residual(const Pair& pair) {
  return pair.target_intensity + pair.target_gradient.dot(pair.moved - pair.target) - pair.source_intensity;
}

}  // namespace

double PointToPlane::squared_error(const Pair& pair) const {
  const double r = pair.target_normal.dot(pair.moved - pair.target);
  return r * r;
}

void PointToPlane::add(const Pair& pair, const Eigen::Matrix3d& R, NormalEquations& equations) const {
  add_row(pair, R, pair.target_normal, pair.target_normal.dot(pair.moved - pair.target), equations);
  equations.weight += pair.weight;
}

double PointToPoint::squared_error(const Pair& pair) const {
  return pair.squared_distance();
}

// In source axes the residual is R^T (T p - q) and J = [I, -hat(p)].
void PointToPoint::add(const Pair& pair, const Eigen::Matrix3d& R, NormalEquations& equations) const {
  const double w = pair.weight;
  const Eigen::Vector3d r = R.transpose() * (pair.moved - pair.target);
  const Eigen::Matrix3d P = w * hat(pair.source);
  equations.H.topLeftCorner<3, 3>().diagonal().array() += w;
  equations.H.topRightCorner<3, 3>() -= P;
  equations.H.bottomLeftCorner<3, 3>() += P;
  equations.H.bottomRightCorner<3, 3>() -= w * pair.source * pair.source.transpose();
  equations.H.bottomRightCorner<3, 3>().diagonal().array() += w * pair.source.squaredNorm();
  equations.b.head<3>() -= w * r;
  equations.b.tail<3>() -= w * pair.source.cross(r);
  equations.squared_error += w * r.squaredNorm();
  equations.weight += 3 * w;
}

double PlaneToPlane::squared_error(const Pair& pair) const {
  const Eigen::Vector3d r = pair.moved - pair.target;
  return r.dot(plane_information(pair) * r);
}

// As point to point in source axes, with the weight matrix R^T M R.
void PlaneToPlane::add(const Pair& pair, const Eigen::Matrix3d& R, NormalEquations& equations) const {
  const Eigen::Matrix3d M = pair.weight * (R.transpose() * plane_information(pair) * R);
  const Eigen::Vector3d r = R.transpose() * (pair.moved - pair.target);
  const Eigen::Matrix3d P = hat(pair.source);
  const Eigen::Matrix3d MP = M * P;
  const Eigen::Vector3d Mr = M * r;
  equations.H.topLeftCorner<3, 3>() += M;
  equations.H.topRightCorner<3, 3>() -= MP;
  equations.H.bottomLeftCorner<3, 3>() -= MP.transpose();
  equations.H.bottomRightCorner<3, 3>().noalias() += P.transpose() * MP;
  equations.b.head<3>() -= Mr;
  equations.b.tail<3>() -= pair.source.cross(Mr);
  equations.squared_error += r.dot(Mr);
  equations.weight += M.trace();
}

double WithColour::squared_error(const Pair& pair) const {
  const double r = scale_ * colour_residual(pair);
  return geometry_->squared_error(pair) + (std::isfinite(r) ? r * r : 0);
}

void WithColour::add(const Pair& pair, const Eigen::Matrix3d& R, NormalEquations& equations) const {
  geometry_->add(pair, R, equations);
  const double r = scale_ * colour_residual(pair);
  if (std::isfinite(r)) add_row(pair, R, scale_ * pair.target_gradient, r, equations);
}

std::unique_ptr<Metric> make_metric(const RegistrationSettings& settings) {
  const auto geometry = [&]() -> std::unique_ptr<Metric> {
    switch (settings.metric) {
      case MetricKind::point_to_point:
        return std::make_unique<PointToPoint>();
      case MetricKind::plane_to_plane:
        return std::make_unique<PlaneToPlane>();
      case MetricKind::point_to_plane:
        break;
    }
    return std::make_unique<PointToPlane>();
  };
  if (!(settings.colour_scale > 0)) return geometry();
  return std::make_unique<WithColour>(geometry(), settings.colour_scale);
}

}  // namespace lcmslam
