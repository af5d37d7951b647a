#include <lcmslam/dense_mapper/thesis/growing_cloud.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <lcmslam/registration/point_lookup.hpp>

namespace lcmslam {

GrowingCloud::GrowingCloud(double merge_distance) : merge_distance_(static_cast<float>(merge_distance)) {
  if (!(merge_distance >= 0) || !std::isfinite(merge_distance))
    throw std::invalid_argument("growing cloud: merge distance " + std::to_string(merge_distance) +
                                " m, must not be negative");
}

std::size_t GrowingCloud::add(const Cloud& cloud) {
  std::vector<std::size_t> fresh;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (cloud.points[i].allFinite() && nearest(cloud.points[i], merge_distance_) < 0) fresh.push_back(i);
  if (fresh.empty()) return 0;

  const std::size_t begin = cloud_.size();
  for (const std::size_t i : fresh) {
    const TargetPoint p = target_point(cloud, i);
    cloud_.points.push_back(p.point);
    cloud_.normals.push_back(p.normal);
    cloud_.sigmas.push_back(p.sigma);
  }
  build(begin);
  return fresh.size();
}

Cloud GrowingCloud::newest(std::size_t count) const {
  const std::size_t begin = cloud_.size() - std::min(count, cloud_.size());
  return kept_points(cloud_, [&](std::size_t i) { return i >= begin; });
}

std::size_t GrowingCloud::memory_bytes() const {
  std::size_t bytes = lcmslam::memory_bytes(cloud_);
  for (const Part& part : parts_) bytes += part.tree.memory_bytes();
  return bytes;
}

// Parts no larger than twice what comes after them are built anew together with it.
void GrowingCloud::build(std::size_t begin) {
  const std::size_t end = cloud_.size();
  while (!parts_.empty() && parts_.back().end - parts_.back().begin <= 2 * (end - begin)) {
    begin = parts_.back().begin;
    parts_.pop_back();
  }
  const auto at = [&](std::size_t i) { return cloud_.points.begin() + static_cast<std::ptrdiff_t>(i); };
  parts_.push_back({begin, end, KdTree({at(begin), at(end)})});
}

std::int32_t GrowingCloud::nearest(const Eigen::Vector3f& point, float max_distance) const {
  std::int32_t index = -1;
  for (const Part& part : parts_) {
    const KdTree::Neighbour n = part.tree.nearest(point, max_distance);
    if (n.index < 0) continue;
    max_distance = std::sqrt(n.squared_distance);
    index = n.index + static_cast<std::int32_t>(part.begin);
  }
  return index;
}

bool GrowingCloud::find(const Eigen::Vector3f& point, float max_distance, TargetPoint& found) const {
  const std::int32_t index = nearest(point, max_distance);
  if (index < 0) return false;
  found = target_point(cloud_, static_cast<std::size_t>(index));
  return true;
}

}  // namespace lcmslam
