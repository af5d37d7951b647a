#pragma once
// Things in the map belong to nodes of the graph, by the node's index, and follow them.

#include <algorithm>
#include <vector>

namespace lcmslam {

/// What `values` holds for a node. Things may belong to a node that came after `values` was made: then they
/// go with the last one.
template <class T>
const T& of_node(const std::vector<T>& values, int node) {
  return values[std::min(static_cast<std::size_t>(node), values.size() - 1)];
}

}  // namespace lcmslam
