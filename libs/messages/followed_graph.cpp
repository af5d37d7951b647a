#include <lcmslam/messages/followed_graph.hpp>

#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t most_nodes = 100'000, most_edges = 1'000'000;

FollowedGraph::Pair pair_of(const graph_edge_t& edge) {
  return {edge.from_node, edge.to_node};
}

}  // namespace

void FollowedGraph::check(const graph_t& message) const {
  from_message(message);
  const bool whole = message.change == 0;
  if (message.nodes.size() + (whole ? 0 : nodes_.size()) > most_nodes ||
      message.edges.size() + (whole ? 0 : edges_.size()) > most_edges)
    throw DecodeError("a graph has at most " + std::to_string(most_nodes) + " nodes and " +
                      std::to_string(most_edges) + " edges");
}

void FollowedGraph::apply(const graph_t& message) {
  check(message);
  const bool whole = message.change == 0;
  if (!whole && heard_ && message.seq <= seq_) return;
  if (whole) {
    nodes_.clear();
    edges_.clear();
  }
  complete_ = whole || (heard_ && complete_ && message.seq == seq_ + 1);
  heard_ = true;
  seq_ = message.seq;
  map_revision_ = message.map_revision;

  for (const std::int32_t id : message.gone) nodes_.erase(id);
  if (!message.gone.empty())
    for (auto edge = edges_.begin(); edge != edges_.end();)
      edge = nodes_.count(edge->first.first) > 0 && nodes_.count(edge->first.second) > 0 ? std::next(edge)
                                                                                         : edges_.erase(edge);
  for (std::size_t i = 0; i < message.cut_from.size(); ++i)
    edges_.erase({message.cut_from[i], message.cut_to[i]});
  for (const graph_edge_t& edge : message.edges) edges_.erase(pair_of(edge));
  for (const graph_node_t& node : message.nodes) nodes_[node.keyframe] = node;
  for (const graph_edge_t& edge : message.edges) edges_.emplace(pair_of(edge), edge);
}

std::vector<KeyframePose> FollowedGraph::poses() const {
  std::vector<KeyframePose> poses;
  poses.reserve(nodes_.size());
  for (const auto& [id, node] : nodes_)
    poses.push_back({id, from_message(node.T_map_camera, "T_map_camera")});
  return poses;
}

bool was_made_after(const graph_t& message, std::int32_t newest_node, std::int32_t id, Utime utime) {
  return newest_node >= 0 && id > newest_node && utime > message.utime;
}

void follow(DenseMap& map, const FollowedGraph& graph, const graph_t& message) {
  std::vector<KeyframePose> poses = graph.poses();
  if (graph.complete()) {
    for (const auto& [id, keyframe] : map.keyframes())
      if (was_made_after(message, graph.newest_node(), id, keyframe.utime))
        poses.push_back({id, keyframe.T_world_camera});
    return map.follow(poses);
  }
  map.correct(poses);
  for (const std::int32_t id : message.gone) map.remove(id);
}

}  // namespace lcmslam
