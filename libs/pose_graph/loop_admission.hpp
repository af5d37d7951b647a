#pragma once
// Which loops a graph believes: one that agrees with what the graph itself expects, or several from different
// places that agree with each other (pairwise consistency: Mangelson et al. 2018).

#include <optional>
#include <vector>

#include <lcmslam/pose_graph/pose_graph.hpp>

namespace lcmslam {

/// The surest chains of edges from one node to all others (Dijkstra 1959, over the edges' covariances).
class SurestChains {
 public:
  SurestChains(const PoseGraph& graph, int from);

  /// T_from_to as the graph has it, with the covariance of the chain between them; nothing when they are not
  /// connected.
  std::optional<UncertainTransform> to(int node) const;

 private:
  std::vector<std::optional<UncertainTransform>> chains_;  // by node
};

/// Takes from `waiting` what can be believed and adds it to the graph: what agrees with the graph's own
/// expectation, and groups that agree with each other. The number added.
int admit(std::vector<GraphEdge>& waiting, PoseGraph& graph, const PoseGraphSettings& settings);

/// Whether any of the edges from number `first` on closes a circle.
bool has_circle(const std::vector<GraphEdge>& edges, std::size_t first = 0);

/// Admits and, where that closes a circle, optimises: until the poses agree with what was admitted, it
/// contradicts all that they are told to err by. Whether it did.
bool close_circles(std::vector<GraphEdge>& waiting, PoseGraph& graph, const PoseGraphSettings& settings);

}  // namespace lcmslam
