#include <lcmslam/pose_graph/graph_thinning.hpp>

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

namespace lcmslam {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

// How far apart two views are; inf as soon as they are farther than `limit`.
double gap(const ThinningNode& a, const ThinningNode& b, const Covering& covering, double limit = inf) {
  const Eigen::Vector3d step = a.T_world_camera.translation() - b.T_world_camera.translation();
  const double distance = step.norm() / covering.distance;
  if (distance >= limit) return inf;
  return distance + rotation_angle(a.T_world_camera.inverse() * b.T_world_camera) / covering.angle;
}

/// The two nearest keyframes that stay.
struct Near {
  int first = -1;
  double first_gap = inf, second_gap = inf;
};

Near nearest(const std::vector<ThinningNode>& nodes, const std::vector<bool>& gone, std::size_t node,
             const Covering& covering) {
  Near near;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (k == node || gone[k] || !nodes[k].keyframe) continue;
    const auto [a, b] = std::minmax(node, k);  // the same gap both ways
    const double g = gap(nodes[a], nodes[b], covering, near.second_gap);
    if (g < near.first_gap) {
      near.second_gap = near.first_gap;
      near.first_gap = g;
      near.first = static_cast<int>(k);
    } else {
      near.second_gap = std::min(near.second_gap, g);
    }
  }
  return near;
}

// The best covered one among those that may go; -1 when there is none.
int best_covered(const std::vector<ThinningNode>& nodes, const std::vector<Near>& near,
                 const std::vector<bool>& gone, bool keyframes) {
  int best = -1;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (gone[k] || nodes[k].fixed || nodes[k].keyframe != keyframes) continue;
    const auto rank = [&](std::size_t i) { return std::make_pair(near[i].first_gap, near[i].second_gap); };
    if (best < 0 || !(rank(static_cast<std::size_t>(best)) < rank(k))) best = static_cast<int>(k);
  }
  return best;
}

GraphEdge reversed(const GraphEdge& e) {
  GraphEdge r = e;
  std::swap(r.from, r.to);
  r.T_from_to = inverse(e.T_from_to);
  return r;
}

bool touches(int node, const GraphEdge& e) {
  return e.from == node || e.to == node;
}

// The node's edges, which leave the others, as ones that lead to it.
std::vector<GraphEdge> taken(int node, std::vector<GraphEdge>& edges) {
  std::vector<GraphEdge> its, rest;
  for (const GraphEdge& e : edges)
    if (touches(node, e))
      its.push_back(e.to == node ? e : reversed(e));
    else
      rest.push_back(e);
  edges = std::move(rest);
  return its;
}

double size_of(const GraphEdge& e) {
  return e.T_from_to.covariance.topLeftCorner<3, 3>().trace();
}

void add(const GraphEdge& edge, std::vector<GraphEdge>& edges) {
  if (edge.kind != EdgeKind::odometry)
    for (GraphEdge& e : edges)
      if (e.kind != EdgeKind::odometry && e.from == edge.from && e.to == edge.to) {
        e = merged(e, edge);
        return;
      }
  edges.push_back(edge);
}

}  // namespace

std::vector<bool> covered_nodes(const std::vector<ThinningNode>& nodes, std::size_t keyframes,
                                std::size_t others, const Covering& covering) {
  std::vector<bool> gone(nodes.size(), false);
  std::vector<Near> near;
  for (std::size_t k = 0; k < nodes.size(); ++k) near.push_back(nearest(nodes, gone, k, covering));
  const auto count_if = [&](bool keyframe) {
    return static_cast<std::size_t>(std::count_if(
        nodes.begin(), nodes.end(), [&](const ThinningNode& n) { return n.keyframe == keyframe; }));
  };
  for (const bool kind : {true, false}) {
    std::size_t left = count_if(kind);
    while (left > (kind ? keyframes : others)) {
      const int best = best_covered(nodes, near, gone, kind);
      if (best < 0) break;
      gone[static_cast<std::size_t>(best)] = true;
      --left;
      if (!kind) continue;  // nobody's neighbour
      for (std::size_t k = 0; k < nodes.size(); ++k)
        if (!gone[k] && gap(nodes[k], nodes[static_cast<std::size_t>(best)], covering,
                            near[k].second_gap + 1e-9) <= near[k].second_gap + 1e-9)
          near[k] = nearest(nodes, gone, k, covering);
    }
  }
  return gone;
}

std::vector<int> successors(const std::vector<ThinningNode>& nodes, const std::vector<bool>& gone,
                            const Covering& covering) {
  std::vector<int> successor;
  int staying = 0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (!gone[k]) staying = static_cast<int>(k);
    const int nearest_keyframe = gone[k] ? nearest(nodes, gone, k, covering).first : staying;
    successor.push_back(nearest_keyframe >= 0 ? nearest_keyframe : staying);
  }
  return successor;
}

std::vector<GraphEdge> surest_edges(const std::vector<GraphEdge>& edges, std::size_t nodes,
                                    std::size_t most) {
  std::vector<std::size_t> order(edges.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return size_of(edges[a]) < size_of(edges[b]); });
  std::map<EdgeKind, std::vector<std::size_t>> taken;  // at each node, surer ones of the kind
  std::vector<bool> stays(edges.size(), true);
  for (const std::size_t i : order) {
    const GraphEdge& e = edges[i];
    if (e.kind == EdgeKind::odometry) continue;
    std::vector<std::size_t>& count = taken[e.kind];
    count.resize(nodes, 0);
    const std::size_t at_from = count[static_cast<std::size_t>(e.from)]++;
    const std::size_t at_to = count[static_cast<std::size_t>(e.to)]++;
    stays[i] = std::min(at_from, at_to) < most;
  }
  std::vector<GraphEdge> kept;
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (stays[i]) kept.push_back(edges[i]);
  return kept;
}

GraphEdge merged(const GraphEdge& a, const GraphEdge& b) {
  const Matrix6d information_a = a.T_from_to.covariance.inverse(),
                 information_b = b.T_from_to.covariance.inverse();
  const Matrix6d information = information_a + information_b;
  const Vector6d step = se3_log(a.T_from_to.T.inverse() * b.T_from_to.T);
  GraphEdge edge = a;
  edge.T_from_to.T = a.T_from_to.T * se3_exp(information.ldlt().solve(information_b * step));
  edge.T_from_to.covariance = information.inverse();
  edge.error = std::max(a.error, b.error);
  edge.expected_share = std::max(a.expected_share, b.expected_share);
  return edge;
}

void marginalise(int node, std::vector<GraphEdge>& edges, std::vector<GraphEdge>& waiting) {
  const std::vector<GraphEdge> its = taken(node, edges), its_waiting = taken(node, waiting);
  const GraphEdge* link = nullptr;
  for (const GraphEdge& e : its)
    if (e.kind == EdgeKind::odometry && (link == nullptr || size_of(e) < size_of(*link))) link = &e;
  if (link == nullptr) return;
  GraphEdge surest = *link;
  for (const GraphEdge& e : its)
    if (e.from == link->from && &e != link) surest = merged(surest, e);
  const GraphEdge onwards = reversed(surest);
  const auto continued = [&](GraphEdge e) {
    e.to = onwards.to;
    e.T_from_to = e.T_from_to * onwards.T_from_to;
    e.expected_share = std::min(e.expected_share, onwards.expected_share);
    return e.from < e.to ? e : reversed(e);
  };
  for (const GraphEdge& e : its)
    if (e.from != onwards.to) add(continued(e), edges);
  for (const GraphEdge& e : its_waiting)
    if (e.from != onwards.to) waiting.push_back(continued(e));
}

}  // namespace lcmslam
