#pragma once
// A kd-tree of descriptors that grows, as the thesis keeps one in every particle (2.3.2, A.1): exact.

#include <utility>
#include <vector>

#include <lcmslam/features/matching.hpp>

namespace lcmslam::testing {

class DescriptorTree {
 public:
  struct Nearest {
    int landmark = -1;  // -1: the tree is empty
    int distance2 = std::numeric_limits<int>::max();
  };

  void insert(const Descriptor& descriptor, int landmark) {
    int* child = &root_;
    for (std::size_t axis = 0; *child >= 0; axis = (axis + 1) % 64) {
      Node& node = nodes_[static_cast<std::size_t>(*child)];
      child = descriptor[axis] < node.descriptor[axis] ? &node.below : &node.above;
    }
    *child = static_cast<int>(nodes_.size());
    nodes_.push_back({descriptor, landmark});
  }

  /// Of equally near ones the older.
  Nearest nearest(const Descriptor& query) const {
    Nearest best;
    search(query, root_, 0, best);
    return best;
  }

 private:
  struct Node {
    Descriptor descriptor;
    int landmark;
    int below = -1, above = -1;
  };

  void search(const Descriptor& query, int at, std::size_t axis, Nearest& best) const {
    if (at < 0) return;
    const Node& node = nodes_[static_cast<std::size_t>(at)];
    const int d2 = squared_distance(query, node.descriptor);
    if (d2 < best.distance2 || (d2 == best.distance2 && node.landmark < best.landmark))
      best = {node.landmark, d2};
    const int side = query[axis] - node.descriptor[axis];
    const std::size_t next = (axis + 1) % 64;
    search(query, side < 0 ? node.below : node.above, next, best);
    if (side * side <= best.distance2) search(query, side < 0 ? node.above : node.below, next, best);
  }

  std::vector<Node> nodes_;
  int root_ = -1;
};

}  // namespace lcmslam::testing
