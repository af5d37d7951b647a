#include <lcmslam/rendering/front_heading.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/rendering/picture_points.hpp>
#include <lcmslam/rendering/view_camera.hpp>

namespace lcmslam {
namespace {

std::vector<Eigen::Vector3d> path_sample(const PictureRequest& request) {
  constexpr std::size_t count = 200;
  std::vector<Eigen::Vector3d> sample;
  for (const PicturePath& path : request.paths)
    for (std::size_t i = 0; i < path.points.size(); i += path.points.size() / count + 1)
      if (path.points[i].allFinite()) sample.push_back(path.points[i]);
  return sample;
}

/// Stands in for a normal that is not known: the direction to the nearest place the robot was at.
std::optional<Eigen::Vector3d> seen_from(const Eigen::Vector3d& point,
                                         const std::vector<Eigen::Vector3d>& path) {
  const auto nearest = std::min_element(path.begin(), path.end(), [&](const auto& a, const auto& b) {
    return (a - point).squaredNorm() < (b - point).squaredNorm();
  });
  if (nearest == path.end() || *nearest == point) return {};
  return (*nearest - point).normalized();
}

/// The directions that surfaces of the map face, of a sample of them.
std::vector<Eigen::Vector3d> facing_directions(const PictureRequest& request) {
  constexpr std::size_t count = 4000;
  const std::vector<Eigen::Vector3d> path = path_sample(request);
  std::vector<Eigen::Vector3d> directions;
  const auto add = [&](const std::optional<Eigen::Vector3d>& direction) {
    if (direction) directions.push_back(*direction);
  };
  if (request.cloud) {
    const ColouredCloud& cloud = *request.cloud;
    for (std::size_t i = 0; i < cloud.size(); i += cloud.size() / count + 1) {
      if (has_normal(cloud, i))
        add(cloud.normals[i].cast<double>().eval());
      else if (cloud.points[i].allFinite())
        add(seen_from(cloud.points[i].cast<double>(), path));
    }
  }
  if (request.landmarks)
    for (std::size_t i = 0; i < request.landmarks->size(); i += request.landmarks->size() / count + 1)
      if ((*request.landmarks)[i].mean.allFinite()) add(seen_from((*request.landmarks)[i].mean, path));
  return directions;
}

}  // namespace

Eigen::Vector2d front_heading(const PictureRequest& request, const std::vector<Eigen::Vector3d>& points) {
  const FloorPlan plan = fit_floor_plan(points);
  const Eigen::Vector2d along = plan.long_axis, across(-along.y(), along.x());
  const std::array<Eigen::Vector2d, 4> headings = {along, across, -along, -across};

  constexpr double one_sided = 2.5;
  std::array<double, 4> area{};  // of surface that each heading sees, as projected
  for (const Eigen::Vector3d& direction : facing_directions(request))
    for (std::size_t i = 0; i < 4; ++i) area[i] += std::max(0.0, -headings[i].dot(direction.head<2>()));
  const auto best = static_cast<std::size_t>(std::max_element(area.begin(), area.end()) - area.begin());
  if (area[best] > one_sided * area[(best + 2) % 4]) return headings[best];

  const bool square = plan.length < 1.2 * plan.width;
  const Eigen::Vector2d axis = square && std::abs(across.x()) > std::abs(along.x()) ? across : along;
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  for (const PicturePath& path : request.paths)
    if (!path.points.empty() && path.points.front().allFinite()) {
      start = path.points.front().head<2>();
      break;
    }
  const double from_centre = axis.dot(start - plan.centre);
  const bool in_the_middle = square || std::abs(from_centre) < 0.1 * plan.length;
  const bool turn = in_the_middle ? axis.x() < 0 : from_centre > 0;
  return turn ? Eigen::Vector2d(-axis) : axis;
}

}  // namespace lcmslam
