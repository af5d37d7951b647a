#include <lcmslam/planes/objects.hpp>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include <lcmslam/cloud/voxel_index.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

/// Tells which points lie within an outline by the sides in their own row alone: outlines of large floors
/// have thousands of corners, and a map a million points.
class OutlineRows {
 public:
  explicit OutlineRows(const std::vector<Eigen::Vector2f>& corners) {
    const auto [lowest, highest] = std::minmax_element(
        corners.begin(), corners.end(), [](const auto& a, const auto& b) { return a.y() < b.y(); });
    low_ = lowest->y();
    high_ = highest->y();
    rows_.resize(row(high_) + 1);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Side side{corners[i], corners[(i + 1) % corners.size()]};
      const auto [from, to] = std::minmax(side.begin.y(), side.end.y());
      for (std::size_t at = row(from); at <= row(to); ++at) rows_[at].push_back(side);
    }
  }

  bool contains(const Eigen::Vector2f& p) const {
    if (!(p.y() >= low_ && p.y() <= high_)) return false;
    bool inside = false;
    for (const auto& [a, b] : rows_[row(p.y())]) {
      if ((a.y() > p.y()) == (b.y() > p.y())) continue;
      if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
    }
    return inside;
  }

 private:
  struct Side {
    Eigen::Vector2f begin, end;
  };
  std::size_t row(float y) const {
    constexpr float height = 0.05F;  // m
    return static_cast<std::size_t>((y - low_) / height);
  }

  float low_ = 0, high_ = 0;
  std::vector<std::vector<Side>> rows_;
};

/// Points over the patch in its frame: x and y in the plane, z above it.
std::vector<Eigen::Vector3f> points_above(const std::vector<Eigen::Vector3f>& points, const PlanePatch& patch,
                                          const Eigen::Isometry3f& T_plane_map,
                                          const ObjectSettings& settings) {
  std::vector<Eigen::Vector2f> corners;
  for (const Eigen::Vector3d& corner : patch.outline) {
    const Eigen::Vector3f p = T_plane_map * corner.cast<float>();
    corners.emplace_back(p.head<2>());
  }
  const OutlineRows outline(corners);
  std::vector<Eigen::Vector3f> above;
  const auto low = static_cast<float>(settings.lift), high = static_cast<float>(settings.height);
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3f p = T_plane_map * point;
    if (!(p.z() > low && p.z() < high)) continue;
    if (outline.contains(p.head<2>())) above.push_back(p);
  }
  return above;
}

/// Points of cells that touch, in the order of their first points.
std::vector<std::vector<Eigen::Vector3f>> clusters_of(const std::vector<Eigen::Vector3f>& points,
                                                      double cell) {
  const float inverse = 1 / static_cast<float>(cell);
  VoxelIndex index;
  std::vector<Eigen::Vector3i> voxels;
  std::vector<std::vector<std::size_t>> members;  // points of each voxel
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3i voxel = voxel_of(points[i], inverse);
    const auto number =
        static_cast<std::size_t>(index.insert(voxel_key(voxel), static_cast<std::int32_t>(voxels.size())));
    if (number == voxels.size()) {
      voxels.push_back(voxel);
      members.emplace_back();
    }
    members[number].push_back(i);
  }
  std::vector<bool> taken(voxels.size(), false);
  std::vector<std::vector<Eigen::Vector3f>> clusters;
  for (std::size_t first = 0; first < voxels.size(); ++first) {
    if (taken[first]) continue;
    taken[first] = true;
    std::vector<std::size_t> reached{first};
    std::vector<Eigen::Vector3f> cluster;
    for (std::size_t next = 0; next < reached.size(); ++next) {
      for (const std::size_t i : members[reached[next]]) cluster.push_back(points[i]);
      for (int n = 0; n < 27; ++n) {
        const std::int32_t found = index.find(
            voxel_key(voxels[reached[next]] + Eigen::Vector3i(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)));
        if (found == VoxelIndex::none || taken[static_cast<std::size_t>(found)]) continue;
        taken[static_cast<std::size_t>(found)] = true;
        reached.push_back(static_cast<std::size_t>(found));
      }
    }
    clusters.push_back(std::move(cluster));
  }
  return clusters;
}

StandingObject box_around(const std::vector<Eigen::Vector3f>& cluster, const Eigen::Isometry3d& T_map_plane) {
  std::vector<cv::Point2f> footprint;
  float top = 0;
  for (const Eigen::Vector3f& p : cluster) {
    footprint.emplace_back(p.x(), p.y());
    top = std::max(top, p.z());
  }
  const cv::RotatedRect rectangle = cv::minAreaRect(footprint);
  double angle = static_cast<double>(rectangle.angle) * CV_PI / 180;
  double length = static_cast<double>(rectangle.size.width),
         width = static_cast<double>(rectangle.size.height);
  if (length < width) {
    std::swap(length, width);
    angle += CV_PI / 2;
  }
  const double height = static_cast<double>(top);
  StandingObject object;
  object.points = static_cast<int>(cluster.size());
  object.size = {length, width, height};
  const Eigen::Vector3d middle(static_cast<double>(rectangle.center.x),
                               static_cast<double>(rectangle.center.y), height / 2);
  object.T_map_box =
      T_map_plane * Eigen::Translation3d(middle) * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ());
  return object;
}

}  // namespace

std::vector<StandingObject> find_objects(const std::vector<Eigen::Vector3f>& points, const PlanePatch& patch,
                                         const ObjectSettings& settings) {
  check(settings, "objects");
  if (patch.outline.size() < 3) return {};
  Eigen::Isometry3d T_map_plane = Eigen::Isometry3d::Identity();
  T_map_plane.linear() << patch.fit.axis, patch.fit.plane.normal.cross(patch.fit.axis),
      patch.fit.plane.normal;
  T_map_plane.translation() = patch.fit.centre;
  const Eigen::Isometry3f T_plane_map = T_map_plane.inverse().cast<float>();
  std::vector<StandingObject> objects;
  for (const auto& cluster : clusters_of(points_above(points, patch, T_plane_map, settings), settings.cell))
    if (cluster.size() >= static_cast<std::size_t>(settings.min_points))
      objects.push_back(box_around(cluster, T_map_plane));
  std::stable_sort(objects.begin(), objects.end(),
                   [](const auto& a, const auto& b) { return a.points > b.points; });
  return objects;
}

}  // namespace lcmslam
