#include <lcmslam/messages/graph_teller.hpp>

#include <algorithm>
#include <utility>

#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>

namespace lcmslam {
namespace {

using Pair = std::pair<std::int32_t, std::int32_t>;

Pair ends_of(const graph_edge_t& edge) {
  return {edge.from_node, edge.to_node};
}

bool equal(const rigid_transform_t& a, const rigid_transform_t& b) {
  return std::equal(std::begin(a.trans), std::end(a.trans), b.trans) &&
         std::equal(std::begin(a.quat), std::end(a.quat), b.quat);
}

bool has_moved(const graph_node_t& told, const graph_node_t& now) {
  if (equal(told.T_map_camera, now.T_map_camera)) return false;
  const Eigen::Isometry3d step = from_message(told.T_map_camera, "T_map_camera").inverse() *
                                 from_message(now.T_map_camera, "T_map_camera");
  return step.translation().norm() > GraphTeller::least_translation ||
         rotation_angle(step) > GraphTeller::least_rotation;
}

/// Its error changes with every solution, what was measured does not.
bool same(const graph_edge_t& a, const graph_edge_t& b) {
  return a.kind == b.kind && equal(a.T_from_to, b.T_from_to) && a.sigma_trans == b.sigma_trans &&
         a.sigma_rot == b.sigma_rot;
}

std::vector<graph_node_t> by_id(std::vector<graph_node_t> nodes) {
  const auto before = [](const graph_node_t& a, const graph_node_t& b) { return a.keyframe < b.keyframe; };
  if (!std::is_sorted(nodes.begin(), nodes.end(), before)) std::sort(nodes.begin(), nodes.end(), before);
  return nodes;
}

/// Sorted by what is small: an edge is some 90 bytes.
std::vector<graph_edge_t> by_pair(std::vector<graph_edge_t> edges) {
  std::vector<std::pair<Pair, std::size_t>> order;
  order.reserve(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) order.emplace_back(ends_of(edges[i]), i);
  if (std::is_sorted(order.begin(), order.end())) return edges;
  std::sort(order.begin(), order.end());
  std::vector<graph_edge_t> sorted;
  sorted.reserve(edges.size());
  for (const auto& [pair, i] : order) sorted.push_back(edges[i]);
  return sorted;
}

using Edge = std::vector<graph_edge_t>::const_iterator;

/// Behind the edges of the first one's pair.
Edge end_of_pair(Edge first, Edge end) {
  return std::find_if(first, end, [&](const graph_edge_t& e) { return ends_of(e) != ends_of(*first); });
}

}  // namespace

graph_t GraphTeller::tell(graph_t whole, bool all) {
  from_message(whole);  // refuses what is no pose
  const bool known = messages_ > 0 && whole.frame == frame_;
  frame_ = whole.frame;
  if (!known || all) {
    nodes_ = by_id(whole.nodes);
    edges_ = by_pair(whole.edges);
  }
  graph_t message = known && !all ? change(std::move(whole)) : std::move(whole);
  message.seq = ++messages_;  // what was told counts for itself: the publisher numbers what goes out
  return message;
}

/// It passes once over the graph and over what was told, side by side: a mapper waits for it.
graph_t GraphTeller::change(graph_t whole) {
  std::vector<graph_node_t> nodes = by_id(std::exchange(whole.nodes, {}));
  std::vector<graph_edge_t> edges = by_pair(std::exchange(whole.edges, {}));
  graph_t change = std::move(whole);
  change.change = 1;
  change_nodes(std::move(nodes), change);
  change_edges(std::move(edges), change);
  change.n_nodes = static_cast<std::int32_t>(change.nodes.size());
  change.n_edges = static_cast<std::int32_t>(change.edges.size());
  change.n_gone = static_cast<std::int32_t>(change.gone.size());
  change.n_cut = static_cast<std::int32_t>(change.cut_from.size());
  return change;
}

void GraphTeller::change_nodes(std::vector<graph_node_t> now, graph_t& change) {
  auto told = nodes_.begin();
  for (graph_node_t& node : now) {
    for (; told != nodes_.end() && told->keyframe < node.keyframe; ++told)
      change.gone.push_back(told->keyframe);
    const bool known = told != nodes_.end() && told->keyframe == node.keyframe;
    if (!known || has_moved(*told, node))
      change.nodes.push_back(node);
    else
      node = *told;  // or it would creep away untold
    if (known) ++told;
  }
  for (; told != nodes_.end(); ++told) change.gone.push_back(told->keyframe);
  nodes_ = std::move(now);
}

void GraphTeller::change_edges(std::vector<graph_edge_t> now, graph_t& change) {
  const auto stays = [&](std::int32_t id) {
    const auto before = [](const graph_node_t& node, std::int32_t than) { return node.keyframe < than; };
    const auto node = std::lower_bound(nodes_.begin(), nodes_.end(), id, before);
    return node != nodes_.end() && node->keyframe == id;
  };
  const auto cut = [&](const Pair& pair) {
    if (!stays(pair.first) || !stays(pair.second)) return;  // it goes with its node
    change.cut_from.push_back(pair.first);
    change.cut_to.push_back(pair.second);
  };
  Edge told = edges_.begin();
  const Edge told_end = edges_.end();
  for (Edge first = now.begin(); first != now.end();) {
    const Pair pair = ends_of(*first);
    for (; told != told_end && ends_of(*told) < pair; told = end_of_pair(told, told_end)) cut(ends_of(*told));
    const Edge last = end_of_pair(first, now.end());
    const Edge same_pair = told;
    if (told != told_end && ends_of(*told) == pair) told = end_of_pair(told, told_end);
    if (!std::equal(first, last, same_pair, told, same)) change.edges.insert(change.edges.end(), first, last);
    first = last;
  }
  for (; told != told_end; told = end_of_pair(told, told_end)) cut(ends_of(*told));
  edges_ = std::move(now);
}

}  // namespace lcmslam
