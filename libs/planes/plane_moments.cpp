#include <lcmslam/planes/plane_moments.hpp>

#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

/// The unit n towards `viewer` that makes n^T spread n / n^T rays n least, by inverse iteration: the two
/// differ so much between a plane's normal and all other directions that few steps do.
Eigen::Vector3d flattest(const Eigen::Matrix3d& spread, const Eigen::Matrix3d& rays,
                         const Eigen::Vector3d& viewer) {
  constexpr double exact = 1e-12;  // m^2; so flat is a plane without any noise
  constexpr int steps = 4;
  const Eigen::Matrix3d inverse = (spread + exact * Eigen::Matrix3d::Identity()).inverse();
  const bool known = rays.trace() > 0;
  Eigen::Vector3d n = viewer.normalized();
  for (int i = 0; i < steps; ++i) n = (inverse * (known ? Eigen::Vector3d(rays * n) : n)).normalized();
  return n.dot(viewer) < 0 ? Eigen::Vector3d(-n) : n;
}

}  // namespace

PlaneMoments moments_about(const Eigen::Vector3d& place, const std::array<double, sums_of_points>& sums) {
  PlaneMoments moments;
  moments.weight = moments.points = sums[0];
  moments.sum = {sums[1], sums[2], sums[3]};
  moments.squares << sums[4], sums[5], sums[6], sums[5], sums[7], sums[8], sums[6], sums[8], sums[9];
  moments.squares += moments.sum * place.transpose() + place * moments.sum.transpose() +
                     moments.weight * place * place.transpose();
  moments.sum += moments.weight * place;
  return moments;
}

PlaneMoments PlaneMoments::moved(const Eigen::Isometry3d& T) const {
  const Eigen::Matrix3d& R = T.linear();
  const Eigen::Vector3d& t = T.translation();
  PlaneMoments result = *this;
  const Eigen::Vector3d turned = R * sum;
  result.sum = turned + weight * t;
  result.squares = R * squares * R.transpose() + turned * t.transpose() + t * turned.transpose() +
                   weight * t * t.transpose();
  result.rays = R * rays * R.transpose();
  return result;
}

PlaneMoments PlaneMoments::weighed(double sigma) const {
  const double factor = 1 / (sigma * sigma);
  const Eigen::Vector3d ray = sum / sum.z();
  PlaneMoments result = *this;
  result.weight *= factor;
  result.sum *= factor;
  result.squares *= factor;
  result.rays = points * ray * ray.transpose();
  return result;
}

double PlaneMoments::rms_from(const PlaneEquation& plane) const {
  const Eigen::Vector3d& n = plane.normal;
  const double mean =
      (n.dot(squares * n) + 2 * plane.offset * n.dot(sum)) / weight + plane.offset * plane.offset;
  return std::sqrt(std::max(mean, 0.0));
}

PlaneFit PlaneMoments::fit(const Eigen::Vector3d& seen_from) const {
  PlaneFit result;
  result.centre = sum / weight;
  const Eigen::Matrix3d spread = squares / weight - result.centre * result.centre.transpose();
  const Eigen::Vector3d normal = flattest(spread, rays, seen_from - result.centre);
  result.plane = {normal, -normal.dot(result.centre)};
  result.rms = std::sqrt(std::max(normal.dot(spread * normal), 0.0));
  // Spreads along the plane's own axes.
  const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  const double uu = u.dot(spread * u), uv = u.dot(spread * v), vv = v.dot(spread * v);
  const double angle = 0.5 * std::atan2(2 * uv, uu - vv);
  result.axis = std::cos(angle) * u + std::sin(angle) * v;
  const double half = std::hypot(0.5 * (uu - vv), uv), longer = 0.5 * (uu + vv) + half,
               shorter = 0.5 * (uu + vv) - half;
  // Tilting about the long axis moves points by their distance from it: the middle spread.
  result.variance = {1 / (weight * std::max(shorter, 1e-9)), 1 / (weight * std::max(longer, 1e-9)),
                     1 / weight};
  return result;
}

}  // namespace lcmslam
