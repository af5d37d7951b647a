#include <lcmslam/ros/transform_tree.hpp>

#include <algorithm>

namespace lcmslam::ros {

void TransformTree::add(const Transform& transform) {
  const auto [known, is_new] =
      edges_.emplace(transform.child_frame, Edge{transform.header.frame, transform.T_parent_child});
  if (is_new || known->second.parent != transform.header.frame) return;
  Edge& edge = known->second;
  edge.moved = std::max(edge.moved, distance_between(edge.T_parent_child, transform.T_parent_child));
  edge.turned = std::max(edge.turned, angle_between(edge.T_parent_child, transform.T_parent_child));
}

bool TransformTree::has(const std::string& frame) const {
  return edges_.count(frame) > 0 || std::any_of(edges_.begin(), edges_.end(), [&](const auto& edge) {
           return edge.second.parent == frame;
         });
}

std::map<std::string, TransformTree::Found> TransformTree::way_up(std::string frame) const {
  std::map<std::string, Found> way;
  Found here;
  while (way.emplace(frame, here).second) {  // a circle ends where it began
    const auto edge = edges_.find(frame);
    if (edge == edges_.end()) break;
    here.T_a_b = edge->second.T_parent_child * here.T_a_b;
    here.moved += edge->second.moved;
    here.turned += edge->second.turned;
    frame = edge->second.parent;
  }
  return way;
}

std::optional<TransformTree::Found> TransformTree::find(const std::string& a, const std::string& b) const {
  const auto from_a = way_up(a), from_b = way_up(b);
  std::optional<Found> nearest;  // the common ancestor with the shortest way that moves least
  for (const auto& [frame, T_frame_a] : from_a) {
    const auto other = from_b.find(frame);
    if (other == from_b.end()) continue;
    const Found found{T_frame_a.T_a_b.inverse() * other->second.T_a_b, T_frame_a.moved + other->second.moved,
                      T_frame_a.turned + other->second.turned};
    if (!nearest || found.moved + found.turned < nearest->moved + nearest->turned) nearest = found;
  }
  return nearest;
}

}  // namespace lcmslam::ros
