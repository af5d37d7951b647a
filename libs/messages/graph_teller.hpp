#pragma once
// What ICP_GRAPH tells: the whole graph of a map once, then what changed, so that its traffic follows what
// happens and not how much there is.

#include <string>
#include <vector>

#include <lcmslam/graph_t.hpp>

namespace lcmslam {

class GraphTeller {
 public:
  /// A node that moved by less since it was told is not told again.
  static constexpr double least_translation = 0.0005;  // m
  static constexpr double least_rotation = 0.0005;     // rad

  /// What is to be published of the graph as it stands, `whole` (change 0): all of it, where that is asked
  /// for or nothing of its frame was told yet, else its difference from what was told. What is told must be
  /// published.
  graph_t tell(graph_t whole, bool all);

 private:
  graph_t change(graph_t whole);
  void change_nodes(std::vector<graph_node_t> now, graph_t& change);
  void change_edges(std::vector<graph_edge_t> now, graph_t& change);

  // As those who hear all messages have it, but for the edges' errors.
  std::vector<graph_node_t> nodes_;  // by id
  std::vector<graph_edge_t> edges_;  // by pair of nodes; those of one pair as the graph had them
  std::string frame_;
  std::int64_t messages_ = 0;
};

}  // namespace lcmslam
