#include <lcmslam/registration/kd_tree_target.hpp>

#include <cmath>
#include <limits>

#include <lcmslam/registration/point_lookup.hpp>

namespace lcmslam {

bool KdTreeTarget::find(const Eigen::Vector3f& point, float max_distance, TargetPoint& found) const {
  const KdTree::Neighbour n = tree_.nearest(point, max_distance);
  if (n.index < 0) return false;
  found = target_point(cloud_, static_cast<std::size_t>(n.index));
  return true;
}

// Among the nearest points, the one nearest to the normal's line.
bool NormalShootingTarget::find_along(const Eigen::Vector3f& point, const Eigen::Vector3f& normal,
                                      float max_distance, TargetPoint& found) const {
  if (!normal.allFinite()) return find(point, max_distance, found);
  constexpr std::size_t candidates = 10;
  float best = std::numeric_limits<float>::infinity();
  std::int32_t index = -1;
  for (const KdTree::Neighbour& n : tree_.nearest_few(point, candidates)) {
    if (!(n.squared_distance <= max_distance * max_distance)) break;
    const Eigen::Vector3f to = cloud_.points[static_cast<std::size_t>(n.index)] - point;
    const float beside = to.squaredNorm() - std::pow(to.dot(normal), 2.0f);
    if (beside >= best) continue;
    best = beside;
    index = n.index;
  }
  if (index < 0) return false;
  found = target_point(cloud_, static_cast<std::size_t>(index));
  return true;
}

}  // namespace lcmslam
