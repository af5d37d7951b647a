#include <lcmslam/dense_mapper/contradiction.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <lcmslam/dense_mapper/free_space.hpp>
#include <lcmslam/dense_mapper/voxel_map.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t enough_surfels = 300;

struct SurfelsInView {
  std::size_t through = 0, supported = 0, hidden = 0;
  std::size_t all() const { return through + supported + hidden; }
};

SurfelsInView count_in_view(const DenseFrame& frame, const Eigen::Isometry3d& T_world_camera,
                            const VoxelMap& map) {
  constexpr double looks_within = 3;  // m from the camera: farther surfaces are seen at too flat angles
  FreeSpaceSettings wide;
  wide.tolerance = 0.25;
  wide.lateral = 0.1;
  const FreeSpaceView view(frame.cloud, wide);
  const Cloud surfels = map.partners_around(T_world_camera.translation(), looks_within);
  const Eigen::Isometry3f T = T_world_camera.inverse().cast<float>();
  SurfelsInView count;
  for (std::size_t i = 0; i < surfels.size(); ++i) {
    const Eigen::Vector3f p = T * surfels.points[i], normal = T.linear() * surfels.normals[i];
    const Visibility seen = view.judge(p, normal);
    count.through += seen == Visibility::seen_through ? 1 : 0;
    count.supported += seen == Visibility::supported ? 1 : 0;
    count.hidden += seen == Visibility::hidden && normal.dot(p) < 0 ? 1 : 0;  // a wall's back always is
  }
  return count;
}

float median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Along the camera's axis, m; NaN without points.
double median_depth(const Cloud& cloud) {
  std::vector<float> depths;
  depths.reserve(cloud.size());
  for (const Eigen::Vector3f& p : cloud.points) depths.push_back(p.z());
  return depths.empty() ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(median(depths));
}

/// A cloud's points from some place in the map.
struct OnMap {
  const VoxelMap& map;
  Eigen::Isometry3f T;  // of the cloud

  /// m, of a point across the surface that it lies on; nothing where there is none.
  std::optional<float> distance(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const {
    constexpr float reach = 0.1f, alike = 0.7f;  // m, cosine
    const Eigen::Vector3f p = T * point;
    TargetPoint there;
    if (!map.find(p, reach, there) || !(there.normal.dot(T.linear() * normal) > alike)) return std::nullopt;
    return std::abs(there.normal.dot(p - there.point));
  }
};

/// Somebody, or a thing that somebody pushes: no wall, and no room.
bool are_one_thing(const std::vector<Eigen::Vector3f>& points) {
  constexpr float half_width = 0.6f;  // m, on the ground
  constexpr double most = 0.9;        // share
  if (points.empty()) return false;
  std::vector<float> x, y;
  for (const Eigen::Vector3f& p : points) x.push_back(p.x()), y.push_back(p.y());
  const Eigen::Vector2f middle(median(x), median(y));
  const auto within = std::count_if(points.begin(), points.end(), [&](const Eigen::Vector3f& p) {
    return (p.head<2>() - middle).norm() < half_width;
  });
  return static_cast<double>(within) > most * static_cast<double>(points.size());
}

/// Such a thing may have come or gone by itself; farther away are other rooms, too.
bool is_close(const Cloud& cloud) {
  constexpr double close = 1.2;  // m
  return median_depth(cloud) < close;
}

}  // namespace

double seen_through(const DenseFrame& frame, const Eigen::Isometry3d& T_world_camera, const VoxelMap& map) {
  const SurfelsInView count = count_in_view(frame, T_world_camera, map);
  const std::size_t seen = count.through + count.supported;
  return seen < enough_surfels ? 0 : static_cast<double>(count.through) / static_cast<double>(seen);
}

bool hides_the_map(const DenseFrame& frame, const Eigen::Isometry3d& T_world_camera, const VoxelMap& map) {
  constexpr double most_seen_through = 0.1, least_hidden = 0.5;  // shares
  if (!is_close(frame.cloud)) return false;
  const SurfelsInView count = count_in_view(frame, T_world_camera, map);
  const std::size_t all = count.all();
  return all >= enough_surfels &&
         static_cast<double>(count.hidden) > least_hidden * static_cast<double>(all) &&
         static_cast<double>(count.through) < most_seen_through * static_cast<double>(all);
}

bool shows_the_map(const DenseFrame& frame, const Eigen::Isometry3d& T_world_camera, const VoxelMap& map) {
  constexpr double most = 0.8;  // share: who steps back from the middle of a room hides half of it
  if (is_close(frame.cloud)) return false;
  const SurfelsInView count = count_in_view(frame, T_world_camera, map);
  return count.all() < enough_surfels ||
         static_cast<double>(count.supported) > most * static_cast<double>(count.all());
}

Standing compare(const Cloud& cloud, const Eigen::Isometry3d& T_stood, const Eigen::Isometry3d& T_led,
                 const VoxelMap& map) {
  constexpr float least_apart = 0.01f;  // m: nearer, noise decides
  const OnMap stood{map, T_stood.cast<float>()}, led{map, T_led.cast<float>()};
  Standing told;
  told.has_moved.assign(cloud.size(), false);
  if (!cloud.has_normals()) return told;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f &p = cloud.points[i], &normal = cloud.normals[i];
    const float apart = std::abs((stood.T.linear() * normal).dot(stood.T * p - led.T * p));
    if (!(apart > least_apart)) continue;
    const auto from_stood = stood.distance(p, normal), from_led = led.distance(p, normal);
    const float nearer =
        std::min(from_led.value_or(apart), apart) - std::min(from_stood.value_or(apart), apart);
    told.has_moved[i] = nearer < 0;
    (told.has_moved[i] ? told.moved : told.stands) += static_cast<double>(std::abs(nearer) / apart);
  }
  return told;
}

std::optional<Cloud> what_stands(const Cloud& cloud, const Eigen::Isometry3d& T_stood,
                                 const Eigen::Isometry3d& T_led, const VoxelMap& map) {
  constexpr double enough = 100, least_share = 0.25;  // points
  if (!cloud.has_normals()) return std::nullopt;
  const Standing told = compare(cloud, T_stood, T_led, map);
  std::vector<Eigen::Vector3f> leading;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (told.has_moved[i]) leading.push_back(cloud.points[i]);
  const bool much_stands = told.stands > enough && told.stands > least_share * (told.stands + told.moved);
  if (!much_stands && !are_one_thing(leading)) return std::nullopt;
  return kept_points(cloud, [&](std::size_t i) { return !told.has_moved[i]; });
}

bool still_shows(const Cloud& cloud, const Eigen::Isometry3d& T_predicted, const Eigen::Isometry3d& T_fitted,
                 const VoxelMap& map) {
  constexpr std::size_t asked = 600, enough = 50;  // points
  constexpr double least = 0.3;                    // share
  constexpr double same_place = 0.05;              // m, rad
  constexpr float upright = 0.5f, on_wall = 0.03f, alike = 0.9f;
  if (!cloud.has_normals() || distance_between(T_predicted, T_fitted) > same_place ||
      angle_between(T_predicted, T_fitted) > same_place)
    return false;
  const Eigen::Isometry3f T = T_fitted.cast<float>();
  std::size_t walls = 0, found = 0;
  TargetPoint there;
  for (std::size_t i = 0; i < cloud.size(); i += 1 + cloud.size() / asked) {
    const Eigen::Vector3f normal = T.linear() * cloud.normals[i];
    if (std::abs(normal.z()) > upright) continue;
    ++walls;
    const Eigen::Vector3f p = T * cloud.points[i];
    if (map.find(p, 2 * on_wall, there) && there.normal.dot(normal) > alike &&
        std::abs(there.normal.dot(p - there.point)) < on_wall)
      ++found;
  }
  return found >= enough && static_cast<double>(found) > least * static_cast<double>(walls);
}

}  // namespace lcmslam
