#include <lcmslam/pose_graph/loop_admission.hpp>

#include <algorithm>
#include <limits>
#include <queue>
#include <set>

namespace lcmslam {
namespace {

double size_of(const Matrix6d& covariance) {
  constexpr double arm = 2;  // m: how far away a rotation's error is felt
  return covariance.topLeftCorner<3, 3>().trace() + arm * arm * covariance.bottomRightCorner<3, 3>().trace();
}

Matrix6d expected_covariance(const GraphEdge& e) {
  return e.expected_share * e.expected_share * e.T_from_to.covariance;
}

// From one end of an edge to the other: the graph's poses, the edge's covariance.
UncertainTransform step(const PoseGraph& graph, const GraphEdge& edge, bool forward) {
  const Eigen::Isometry3d& T_from = graph.poses[static_cast<std::size_t>(edge.from)];
  const Eigen::Isometry3d& T_to = graph.poses[static_cast<std::size_t>(edge.to)];
  const UncertainTransform along{T_from.inverse() * T_to, expected_covariance(edge)};
  return forward ? along : inverse(along);
}

// The chains that lead away from both ends of an edge that waits.
struct ChainsOfEdge {
  SurestChains from, to;

  ChainsOfEdge(const PoseGraph& graph, const GraphEdge& edge) : from(graph, edge.from), to(graph, edge.to) {}
};

// Whether both, with the graph's chains between their ends, close a circle.
bool consistent(const GraphEdge& a, const ChainsOfEdge& chains_of_a, const GraphEdge& b,
                const PoseGraphSettings& settings) {
  const auto between_ends = chains_of_a.to.to(b.to);
  const auto between_starts = chains_of_a.from.to(b.from);
  if (!between_ends || !between_starts) return false;
  const UncertainTransform circle =
      a.T_from_to * *between_ends * inverse(b.T_from_to) * inverse(*between_starts);
  return distance_from_identity(circle) < settings.path_gate;
}

// Whether enough others from different places agree with number i.
bool supported(std::size_t i, const ChainsOfEdge& chains, const std::vector<GraphEdge>& waiting,
               const PoseGraphSettings& settings) {
  std::set<int> places = {waiting[i].to};
  const auto enough = [&] { return static_cast<int>(places.size()) >= settings.loop_support; };
  for (std::size_t k = 0; k < waiting.size() && !enough(); ++k)
    if (places.count(waiting[k].to) == 0 && consistent(waiting[i], chains, waiting[k], settings))
      places.insert(waiting[k].to);
  return enough();
}

}  // namespace

SurestChains::SurestChains(const PoseGraph& graph, int from) : chains_(graph.poses.size()) {
  const std::size_t n = graph.poses.size();
  std::vector<std::vector<const GraphEdge*>> edges(n);
  for (const GraphEdge& e : graph.edges) {
    edges[static_cast<std::size_t>(e.from)].push_back(&e);
    edges[static_cast<std::size_t>(e.to)].push_back(&e);
  }
  std::vector<double> cost(n, std::numeric_limits<double>::infinity());
  std::vector<const GraphEdge*> last(n, nullptr);  // edge of the surest chain so far
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> open;
  cost[static_cast<std::size_t>(from)] = 0;
  open.push({0, from});
  while (!open.empty()) {
    const int here = open.top().second;
    const auto h = static_cast<std::size_t>(here);
    open.pop();
    if (chains_[h]) continue;
    if (last[h]) {
      const bool forward = last[h]->to == here;
      const auto before = static_cast<std::size_t>(forward ? last[h]->from : last[h]->to);
      chains_[h] = *chains_[before] * step(graph, *last[h], forward);
    } else {
      chains_[h] = UncertainTransform();
    }
    for (const GraphEdge* e : edges[h]) {
      const int next = e->from == here ? e->to : e->from;
      const double there = cost[h] + size_of(expected_covariance(*e));
      if (there >= cost[static_cast<std::size_t>(next)]) continue;
      cost[static_cast<std::size_t>(next)] = there;
      last[static_cast<std::size_t>(next)] = e;
      open.push({there, next});
    }
  }
}

std::optional<UncertainTransform> SurestChains::to(int node) const {
  return chains_[static_cast<std::size_t>(node)];
}

int admit(std::vector<GraphEdge>& waiting, PoseGraph& graph, const PoseGraphSettings& settings) {
  std::vector<bool> believed;
  for (std::size_t i = 0; i < waiting.size(); ++i) {
    const GraphEdge& edge = waiting[i];
    const ChainsOfEdge chains(graph, edge);
    const auto known = chains.from.to(edge.to);
    const bool expected =
        known && distance_from_identity(inverse(edge.T_from_to) * *known) < settings.path_gate;
    believed.push_back(expected || supported(i, chains, waiting, settings));
  }
  std::vector<GraphEdge> rest;
  for (std::size_t i = 0; i < waiting.size(); ++i) (believed[i] ? graph.edges : rest).push_back(waiting[i]);
  const auto added = static_cast<int>(waiting.size() - rest.size());
  waiting = std::move(rest);
  return added;
}

bool has_circle(const std::vector<GraphEdge>& edges, std::size_t first) {
  return std::any_of(edges.begin() + static_cast<std::ptrdiff_t>(first), edges.end(),
                     [](const GraphEdge& e) { return e.to - e.from > 1; });
}

bool close_circles(std::vector<GraphEdge>& waiting, PoseGraph& graph, const PoseGraphSettings& settings) {
  const std::size_t before = graph.edges.size();
  admit(waiting, graph, settings);
  if (!has_circle(graph.edges, before)) return false;
  optimise(graph, settings);
  return true;
}

}  // namespace lcmslam
