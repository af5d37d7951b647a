#pragma once
// Small graphs as ICP_GRAPH tells them.

#include <utility>
#include <vector>

#include <lcmslam/messages/followed_graph.hpp>
#include <lcmslam/messages/geometry_messages.hpp>

namespace lcmslam::testing {

/// x: m, of its place.
inline graph_node_t node(std::int32_t id, double x) {
  graph_node_t n{};
  n.keyframe = id;
  n.keyframe_utime = 1000 * id;
  n.T_map_camera = to_message(Eigen::Isometry3d(Eigen::Isometry3d::Identity()));
  n.T_map_camera.trans[0] = x;
  return n;
}

inline graph_edge_t edge(std::int32_t from, std::int32_t to, int kind, double x = 1) {
  graph_edge_t e{};
  e.from_node = from;
  e.to_node = to;
  e.kind = static_cast<std::int8_t>(kind);
  e.T_from_to = node(0, x).T_map_camera;
  e.sigma_trans = 0.01F;
  e.sigma_rot = 0.005F;
  return e;
}

/// The whole graph.
inline graph_t graph_of(std::int64_t seq, std::vector<graph_node_t> nodes, std::vector<graph_edge_t> edges) {
  graph_t m{};
  m.seq = seq;
  m.sender = 5;
  m.frame = "map";
  m.nodes = std::move(nodes);
  m.edges = std::move(edges);
  m.n_nodes = static_cast<std::int32_t>(m.nodes.size());
  m.n_edges = static_cast<std::int32_t>(m.edges.size());
  return m;
}

inline std::vector<std::int32_t> ids_of(const FollowedGraph& graph) {
  std::vector<std::int32_t> ids;
  for (const auto& [id, n] : graph.nodes()) ids.push_back(id);
  return ids;
}

}  // namespace lcmslam::testing
