#include <lcmslam/rendering/view_camera.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lcmslam {
namespace {

constexpr double outliers = 0.002;  // share of the points on each side that may be none of the map
constexpr double apart = 0.05;      // of the extent of the others: so far beyond them they are none
constexpr double pi = 3.14159265358979323846;

struct Extent {
  double low, high;
  double middle() const { return (low + high) / 2; }
  double size() const { return high - low; }
};

template <class Coordinate>
Extent robust_extent(const std::vector<Eigen::Vector3d>& points, const Coordinate& coordinate) {
  std::vector<double> values;
  values.reserve(points.size());
  for (const Eigen::Vector3d& point : points) values.push_back(coordinate(point));
  return {quantile(values, outliers), quantile(values, 1 - outliers)};
}

/// Of all points but those that lie apart: the rim of a map has few points, and near the viewer it is large.
template <class Coordinate>
Extent whole_extent(const std::vector<Eigen::Vector3d>& points, const Coordinate& coordinate) {
  if (points.empty()) return {0, 0};
  std::vector<double> values;
  values.reserve(points.size());
  for (const Eigen::Vector3d& point : points) values.push_back(coordinate(point));
  std::sort(values.begin(), values.end());
  auto low = static_cast<std::size_t>(outliers * static_cast<double>(values.size() - 1));
  std::size_t high = values.size() - 1 - low;
  const double gap = apart * (values[high] - values[low]);
  while (low > 0 && values[low] - values[low - 1] <= gap) --low;
  while (high + 1 < values.size() && values[high + 1] - values[high] <= gap) ++high;
  return {values[low], values[high]};
}

}  // namespace

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const double position = share * static_cast<double>(values.size() - 1);
  // Outwards, so that few points are never cut.
  const auto rank = static_cast<std::ptrdiff_t>(share < 0.5 ? std::floor(position) : std::ceil(position));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

Eigen::Vector3d ViewCamera::project(const Eigen::Vector3d& world) const {
  const Eigen::Vector3d p = T_camera_world * world;
  const double zoom = pixels_per_metre(p.z());
  return {cx + zoom * p.x(), cy + zoom * p.y(), p.z()};
}

Eigen::Vector3d ViewCamera::towards_viewer(const Eigen::Vector3d& world) const {
  if (orthographic) return -T_camera_world.linear().row(2).transpose();
  return (T_camera_world.inverse().translation() - world).normalized();
}

FloorPlan fit_floor_plan(const std::vector<Eigen::Vector3d>& points) {
  FloorPlan best;
  double least_area = std::numeric_limits<double>::infinity();
  // A rectangle repeats after a quarter turn.
  for (int degrees = 0; degrees < 90; degrees += 2) {
    const double angle = degrees * pi / 180;
    const Eigen::Vector2d u(std::cos(angle), std::sin(angle)), v(-u.y(), u.x());
    const Extent along = robust_extent(points, [&](const Eigen::Vector3d& p) { return u.dot(p.head<2>()); });
    const Extent across = robust_extent(points, [&](const Eigen::Vector3d& p) { return v.dot(p.head<2>()); });
    const double area = along.size() * across.size();
    if (!(area < least_area)) continue;
    least_area = area;
    best.centre = along.middle() * u + across.middle() * v;
    best.long_axis = along.size() >= across.size() ? u : v;
    best.length = std::max(along.size(), across.size());
    best.width = std::min(along.size(), across.size());
  }
  return best;
}

ViewCamera fit_top_view(const std::vector<Eigen::Vector3d>& points, const ViewFrame& frame) {
  const Extent x = whole_extent(points, [](const Eigen::Vector3d& p) { return p.x(); });
  const Extent y = whole_extent(points, [](const Eigen::Vector3d& p) { return p.y(); });
  const Extent z = whole_extent(points, [](const Eigen::Vector3d& p) { return p.z(); });
  constexpr double least = 1.0;  // m: a single point is not blown up to fill the picture
  constexpr double room = 1.06;
  ViewCamera camera;
  camera.orthographic = true;
  camera.scale = std::min(frame.width / (room * std::max(x.size(), least)),
                          frame.height / (room * std::max(y.size(), least)));
  camera.cx = frame.left + frame.width / 2;
  camera.cy = frame.top + frame.height / 2;
  Eigen::Matrix3d R_camera_world;
  R_camera_world << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  camera.T_camera_world.linear() = R_camera_world;
  camera.T_camera_world.translation() = -R_camera_world * Eigen::Vector3d(x.middle(), y.middle(), z.high + 1);
  return camera;
}

ViewCamera fit_perspective(const std::vector<Eigen::Vector3d>& points, const ViewFrame& frame,
                           const Eigen::Vector2d& heading, double pitch, double field_of_view) {
  const Eigen::Vector3d forward(heading.x() * std::cos(pitch), heading.y() * std::cos(pitch),
                                -std::sin(pitch));
  const Eigen::Vector3d right(heading.y(), -heading.x(), 0);
  Eigen::Matrix3d R_camera_world;
  R_camera_world << right.transpose(), forward.cross(right).transpose(), forward.transpose();

  // A point (x, y, z) in view axes is inside the frustum of an eye e when |x - ex| <= t (z - ez), and
  // likewise for y: the eye lies between two lines of slope t. The nearest eye stands where they meet;
  // from farther away the middle between them is the same.
  const double tan_x = std::tan(field_of_view / 2);
  const double tan_y = tan_x * frame.height / frame.width;
  const auto line = [&](int axis, double slope) {
    return whole_extent(points, [&](const Eigen::Vector3d& p) {
      return R_camera_world.row(axis).dot(p) + slope * R_camera_world.row(2).dot(p);
    });
  };
  Eigen::Vector3d eye;
  const double x_low = line(0, tan_x).low, x_high = line(0, -tan_x).high;
  const double y_low = line(1, tan_y).low, y_high = line(1, -tan_y).high;
  eye.x() = (x_low + x_high) / 2;
  eye.y() = (y_low + y_high) / 2;
  eye.z() = std::min((x_low - x_high) / (2 * tan_x), (y_low - y_high) / (2 * tan_y));
  const Extent depth =
      whole_extent(points, [&](const Eigen::Vector3d& p) { return R_camera_world.row(2).dot(p); });
  eye.z() = std::min(eye.z(), depth.low - 0.5) - 0.02 * depth.size();

  ViewCamera camera;
  camera.T_camera_world.linear() = R_camera_world;
  camera.T_camera_world.translation() = -eye;
  camera.scale = frame.width / 2 / tan_x;
  camera.cx = frame.left + frame.width / 2;
  camera.cy = frame.top + frame.height / 2;
  return camera;
}

}  // namespace lcmslam
