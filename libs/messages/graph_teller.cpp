#include <lcmslam/messages/graph_teller.hpp>

#include <algorithm>

#include <lcmslam/messages/geometry_messages.hpp>

namespace lcmslam {
namespace {

using Edges = std::multimap<FollowedGraph::Pair, graph_edge_t>;

bool has_moved(const graph_node_t& told, const graph_node_t& now) {
  const Eigen::Isometry3d step = from_message(told.T_map_camera, "T_map_camera").inverse() *
                                 from_message(now.T_map_camera, "T_map_camera");
  return step.translation().norm() > GraphTeller::least_translation ||
         rotation_angle(step) > GraphTeller::least_rotation;
}

/// Its error changes with every solution, what was measured does not.
bool same(const graph_edge_t& a, const graph_edge_t& b) {
  const auto equal = [](const auto& u, const auto& v) { return std::equal(std::begin(u), std::end(u), v); };
  return a.kind == b.kind && equal(a.T_from_to.trans, b.T_from_to.trans) &&
         equal(a.T_from_to.quat, b.T_from_to.quat) && a.sigma_trans == b.sigma_trans &&
         a.sigma_rot == b.sigma_rot;
}

bool same_between(const FollowedGraph::Pair& pair, const Edges& a, const Edges& b) {
  const auto [a_begin, a_end] = a.equal_range(pair);
  const auto [b_begin, b_end] = b.equal_range(pair);
  return std::equal(a_begin, a_end, b_begin, b_end,
                    [](const auto& u, const auto& v) { return same(u.second, v.second); });
}

}  // namespace

graph_t GraphTeller::tell(graph_t whole, bool all) {
  const bool known = messages_ > 0 && whole.frame == frame_;
  graph_t message = known && !all ? change(whole) : std::move(whole);
  message.seq = ++messages_;  // told_ counts for itself: the publisher numbers what goes out
  frame_ = message.frame;
  told_.apply(message);
  return message;
}

graph_t GraphTeller::change(const graph_t& whole) const {
  FollowedGraph now;
  now.apply(whole);
  graph_t change = whole;
  change.change = 1;
  change.nodes.clear();
  change.edges.clear();
  for (const auto& [id, node] : now.nodes()) {
    const auto told = told_.nodes().find(id);
    if (told == told_.nodes().end() || has_moved(told->second, node)) change.nodes.push_back(node);
  }
  for (const auto& [id, node] : told_.nodes())
    if (now.nodes().count(id) == 0) change.gone.push_back(id);

  for (const auto& [pair, edge] : now.edges())
    if (!same_between(pair, told_.edges(), now.edges())) change.edges.push_back(edge);
  const auto stays = [&](std::int32_t id) { return now.nodes().count(id) > 0; };
  for (auto told = told_.edges().begin(); told != told_.edges().end();
       told = told_.edges().upper_bound(told->first)) {
    const auto& [from, to] = told->first;
    if (now.edges().count(told->first) > 0 || !stays(from) || !stays(to)) continue;
    change.cut_from.push_back(from);
    change.cut_to.push_back(to);
  }
  change.n_nodes = static_cast<std::int32_t>(change.nodes.size());
  change.n_edges = static_cast<std::int32_t>(change.edges.size());
  change.n_gone = static_cast<std::int32_t>(change.gone.size());
  change.n_cut = static_cast<std::int32_t>(change.cut_from.size());
  return change;
}

}  // namespace lcmslam
