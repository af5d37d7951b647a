#include <lcmslam/rendering/orbit.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/rendering/front_heading.hpp>
#include <lcmslam/rendering/picture_points.hpp>
#include <lcmslam/rendering/view_camera.hpp>

namespace lcmslam {
namespace {

constexpr double orbit_pitch = 0.5;   // rad, the viewer looks down by this much
constexpr double shown = 0.98;        // share of the points that fall into the picture from everywhere
constexpr double least_radius = 0.5;  // m: a single point is not blown up to fill the picture

double middle(const std::vector<Eigen::Vector3d>& points, int axis) {
  std::vector<double> values;
  for (const Eigen::Vector3d& point : points) values.push_back(point[axis]);
  return (quantile(values, 1 - shown) + quantile(values, shown)) / 2;
}

}  // namespace

std::vector<Eigen::Isometry3d> orbit(const PictureRequest& request, int count) {
  const std::vector<Eigen::Vector3d> points = PicturePoints(request).extent(nullptr);
  const Eigen::Vector3d centre(middle(points, 0), middle(points, 1), middle(points, 2));
  std::vector<double> distances;
  for (const Eigen::Vector3d& point : points) distances.push_back((point - centre).norm());
  const double radius = std::max(quantile(distances, shown), least_radius);
  const double half_height = std::atan(std::tan(request.field_of_view / 2) * request.height / request.width);
  const double distance = radius / std::sin(std::min(half_height, request.field_of_view / 2));

  const Eigen::Vector2d front = front_heading(request, points);
  std::vector<Eigen::Isometry3d> viewers;
  for (int i = 0; i < count; ++i) {
    const double angle = std::atan2(front.y(), front.x()) + 2 * M_PI * i / count;
    const Eigen::Vector3d forward(std::cos(angle) * std::cos(orbit_pitch),
                                  std::sin(angle) * std::cos(orbit_pitch), -std::sin(orbit_pitch));
    const Eigen::Vector3d right(std::sin(angle), -std::cos(angle), 0);
    Eigen::Isometry3d T_world_viewer = Eigen::Isometry3d::Identity();
    T_world_viewer.linear() << right, forward.cross(right), forward;
    T_world_viewer.translation() = centre - distance * forward;
    viewers.push_back(T_world_viewer);
  }
  return viewers;
}

}  // namespace lcmslam
