#include <lcmslam/simulation/ground.hpp>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {
namespace {

constexpr int rounds = 3;  // a tilted robot's wheels stand nearer to each other, seen from above

bool covers(const GroundProfile& profile, const Eigen::Vector2d& p) {
  return std::abs(p.y()) <= profile.width / 2 && p.x() >= profile.points.front().x() &&
         p.x() <= profile.points.back().x();
}

double height_at(const GroundProfile& profile, double along) {
  const auto& points = profile.points;
  std::size_t i = 1;
  while (i + 1 < points.size() && points[i].x() < along) ++i;
  const double fraction = (along - points[i - 1].x()) / (points[i].x() - points[i - 1].x());
  return points[i - 1].y() + fraction * (points[i].y() - points[i - 1].y());
}

}  // namespace

Ground::Ground(std::vector<GroundProfile> profiles) : profiles_(std::move(profiles)) {
  for (const GroundProfile& profile : profiles_) {
    if (profile.points.size() < 2) throw std::invalid_argument("a ground profile needs at least two points");
    for (std::size_t i = 1; i < profile.points.size(); ++i)
      if (!(profile.points[i].x() > profile.points[i - 1].x()))
        throw std::invalid_argument("a ground profile's points must ascend along its way");
  }
}

double Ground::height(const Eigen::Vector2d& place) const {
  double highest = 0;
  for (const GroundProfile& profile : profiles_) {
    const Eigen::Vector2d p = profile.T_world_profile.inverse() * place;
    if (covers(profile, p)) highest = std::max(highest, height_at(profile, p.x()));
  }
  return highest;
}

// max over u of h(place + u forward) + sqrt(r^2 - u^2) - r. The ground is piecewise linear in u, so the
// maximum lies at a corner of it or where its slope m is the circle's: u = r m / sqrt(1 + m^2).
double Ground::height_of_wheel(const Eigen::Vector2d& place, const Eigen::Vector2d& forward,
                               double radius) const {
  double highest = height(place);
  const auto touch = [&](double u) {
    if (std::abs(u) < radius)
      highest = std::max(highest, height(place + u * forward) + std::sqrt(radius * radius - u * u) - radius);
  };
  for (const GroundProfile& profile : profiles_) {
    const Eigen::Vector2d p = profile.T_world_profile.inverse() * place;
    const double along = (profile.T_world_profile.linear().transpose() * forward).x();
    if (std::abs(along) < 1e-9) continue;
    for (std::size_t i = 0; i < profile.points.size(); ++i) {
      touch((profile.points[i].x() - p.x()) / along);
      if (i == 0) continue;
      const Eigen::Vector2d segment = profile.points[i] - profile.points[i - 1];
      const double slope = along * segment.y() / segment.x();
      touch(radius * slope / std::hypot(1, slope));
    }
  }
  return highest;
}

Eigen::Isometry3d stand_on(const Ground& ground, const std::vector<CarryingWheel>& wheels,
                           const Eigen::Isometry3d& T_floor) {
  if (ground.is_flat() || wheels.empty()) return T_floor;
  const Eigen::Vector2d centre = T_floor.translation().head<2>();
  const double heading = yaw(T_floor);
  const Eigen::Vector2d forward(std::cos(heading), std::sin(heading));
  Eigen::Isometry3d T = T_floor;
  for (int round = 0; round < rounds; ++round) {
    // The plane z = a + g . (place - centre).
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const CarryingWheel& wheel : wheels) {
      const Eigen::Vector2d place = (T * Eigen::Vector3d(wheel.x, wheel.y, 0)).head<2>();
      const Eigen::Vector3d row(1, place.x() - centre.x(), place.y() - centre.y());
      normal += row * row.transpose();
      right += row * ground.height_of_wheel(place, forward, wheel.radius);
    }
    const Eigen::Vector3d plane = normal.ldlt().solve(right);
    const Eigen::Vector3d x =
        Eigen::Vector3d(forward.x(), forward.y(), plane.tail<2>().dot(forward)).normalized();
    const Eigen::Vector3d z = Eigen::Vector3d(-plane.y(), -plane.z(), 1).normalized();
    T.translation().z() = plane.x();
    T.linear() << x, z.cross(x), z;
  }
  return T;
}

}  // namespace lcmslam
