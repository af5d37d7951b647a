#include <lcmslam/pose_graph/keyframe_graph.hpp>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numeric>
#include <set>

#include <lcmslam/pose_graph/loop_admission.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr int loop_span = 10;              // nodes; edges that span more close a loop
constexpr double least_correction = 1e-6;  // m, rad: below, rounding
// Nodes that are no keyframes only keep the path's place. A robot that comes by again and again makes them
// and no keyframes: without a bound of their own the graph of a known place would grow for hours. So would
// its edges, which the nodes that go leave behind.
constexpr std::size_t others_at_least = 50;  // and as many as there are keyframes
constexpr std::size_t edges_of_a_kind = 2;   // of each node, once nodes go

Matrix6d squares(double translation, double rotation) {
  Matrix6d m = Matrix6d::Zero();
  m.diagonal().head<3>().setConstant(translation * translation);
  m.diagonal().tail<3>().setConstant(rotation * rotation);
  return m;
}

// Products of many transforms drift away from rotations; corrections must not carry that on.
Eigen::Isometry3d rigid(const Eigen::Isometry3d& T) {
  Eigen::Isometry3d result = T;
  result.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  return result;
}

bool holds(const std::vector<int>& nodes, int node) {
  return std::find(nodes.begin(), nodes.end(), node) != nodes.end();
}

std::vector<int> nearest(const PoseGraph& graph, const LoopFinder& finder, int node,
                         const KeyframeGraphSettings& settings) {
  const Eigen::Isometry3d& T_world_camera = graph.poses[static_cast<std::size_t>(node)];
  std::vector<std::pair<double, int>> near;
  for (int other = 0; other + 1 < node; ++other) {
    if (finder.view(other) == nullptr) continue;
    const Eigen::Isometry3d step = graph.poses[static_cast<std::size_t>(other)].inverse() * T_world_camera;
    const double distance = step.translation().norm() / settings.max_distance;
    const double angle = rotation_angle(step) / settings.max_angle;
    if (distance < 1 && angle < 1) near.emplace_back(distance + angle, other);
  }
  std::sort(near.begin(), near.end());
  std::vector<int> nodes;
  for (const auto& [distance, other] : near)
    if (static_cast<int>(nodes.size()) < settings.neighbours) nodes.push_back(other);
  return nodes;
}

// Whether the graph knows T_from_to so badly, in some direction, that another pair of clouds is worth it:
// those that overlap a little err alike, and do harm beside a circle that is closed.
bool is_vague(const PoseGraph& graph, int from, int to, const KeyframeGraphSettings& settings) {
  const auto known = SurestChains(graph, from).to(to);
  if (!known) return true;
  constexpr double least = 1e-12;  // m^2, rad^2: the floor may be nothing
  const Matrix6d of_edge =
      squares(settings.loops.floor_translation, settings.loops.floor_rotation) + least * Matrix6d::Identity();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6d> ratios(known->covariance, of_edge,
                                                                  Eigen::EigenvaluesOnly);
  return ratios.eigenvalues().maxCoeff() > settings.vague * settings.vague;
}

// Those whose surfaces it shows again after a while, from wherever it sees them: features are not found again
// from another side, surfaces are.
std::vector<int> shown_again(const PoseGraph& graph, const LoopFinder& finder, const KeyframeView& view,
                             const std::vector<int>& near, const KeyframeGraphSettings& settings) {
  std::vector<int> nodes;
  for (const int other : view.shows)
    if (static_cast<int>(nodes.size()) < settings.shown && view.node - other > loop_span &&
        finder.view(other) != nullptr && !holds(near, other) && !holds(nodes, other) &&
        is_vague(graph, other, view.node, settings))
      nodes.push_back(other);
  return nodes;
}

}  // namespace

KeyframeGraph::KeyframeGraph(const KeyframeGraphSettings& settings)
    : settings_(settings), finder_(settings.loops) {
  check(settings, "keyframe graph");
}

int KeyframeGraph::add(Utime utime, const Eigen::Isometry3d& T_world_camera, const Matrix6d& covariance,
                       KeyframeView view, bool keyframe, Floor floor, PlacedBy by) {
  const auto id = static_cast<int>(nodes_.size());
  view.node = id;
  if (id > 0) {
    GraphEdge edge;
    edge.from = by == PlacedBy::relocalisation && !view.shows.empty() ? view.shows.front() : id - 1;
    edge.to = id;
    const Node& before = nodes_[static_cast<std::size_t>(edge.from)];
    edge.T_from_to = {before.T_world_camera.inverse() * T_world_camera,
                      covariance + squares(settings_.floor_translation, settings_.floor_rotation)};
    if (by == PlacedBy::odometry) {
      edge.expected_share = settings_.optimiser.edge_error;  // that this is weighed as all others are
      edge.T_from_to.covariance = covariance / (edge.expected_share * edge.expected_share);
    }
    edges_.push_back(edge);
  }
  nodes_.push_back({utime, T_world_camera, next_id_++, keyframe, floor, {}, {}});
  carry_error(nodes_.size() - 1);
  if (settings_.enabled) fresh_.push_back({std::make_shared<KeyframeView>(std::move(view)), keyframe, utime});
  return id;
}

bool KeyframeGraph::add_features(int node, const FeatureFrame& features) {
  for (NewNode& added : fresh_) {
    if (added.view->node != node) continue;
    added.view->features = features;
    return true;
  }
  return false;
}

void KeyframeGraph::begin(Utime now, Optimise when) {
  PoseGraph graph;
  for (const Node& node : nodes_) graph.poses.push_back(node.T_world_camera);
  graph.edges = edges_;
  graph.ground = ground_;
  for (const Node& node : nodes_)
    if (graph.ground) graph.ground->floors.push_back(node.floor);
  edges_begun_ = edges_.size();
  finder_bytes_ = finder_.memory_bytes();
  const double seconds = settings_.time + settings_.time_per_node * static_cast<double>(nodes_.size());
  due_ = now + static_cast<Utime>(1e6 * seconds);
  running_ =
      std::async(std::launch::async, [graph = std::move(graph), waiting = waiting_, fresh = std::move(fresh_),
                                      &finder = finder_, settings = settings_, when]() mutable {
        return solve(std::move(graph), std::move(waiting), fresh, finder, settings, when);
      });
  fresh_.clear();
}

KeyframeGraph::Solution KeyframeGraph::solve(PoseGraph graph, std::vector<GraphEdge> waiting,
                                             const std::vector<NewNode>& fresh, LoopFinder& finder,
                                             const KeyframeGraphSettings& settings, Optimise when) {
  for (const NewNode& added : fresh) {
    const KeyframeView& view = *added.view;
    // Compare with the last one, with those near or shown again, with loop candidates.
    std::vector<int> near = nearest(graph, finder, view.node, settings);
    if (finder.view(view.node - 1) != nullptr) near.push_back(view.node - 1);
    for (const int other : shown_again(graph, finder, view, near, settings)) near.push_back(other);
    std::vector<int> known = near;
    for (const int candidate : finder.candidates(view.features, known)) known.push_back(candidate);
    for (const int other : known) {
      const bool is_near = holds(near, other);
      const Eigen::Isometry3d T_from_to = graph.poses[static_cast<std::size_t>(other)].inverse() *
                                          graph.poses[static_cast<std::size_t>(view.node)];
      const auto measured =
          finder.verify(*finder.view(other), view, is_near ? std::make_optional(T_from_to) : std::nullopt);
      if (!measured) continue;
      const EdgeKind kind = view.node - other > loop_span ? EdgeKind::loop : EdgeKind::registration;
      waiting.push_back({other, view.node, kind, *measured, 0});
    }
    if (added.keyframe) finder.add(added.view);
  }
  Solution solution;
  const bool optimised = close_circles(waiting, graph, settings.optimiser);
  if (!optimised && when == Optimise::any_circle && has_circle(graph.edges))
    optimise(graph, settings.optimiser);
  solution.factors = lcmslam::error_factors(graph, settings.optimiser);
  solution.errors = pose_errors(graph, settings.optimiser, solution.factors);
  solution.map_errors = pose_errors(graph, settings.optimiser, solution.factors, EdgeErrors::alike);
  solution.graph = std::move(graph);
  solution.waiting = std::move(waiting);
  return solution;
}

void KeyframeGraph::take(Solution solution) {
  solution.graph.edges.insert(solution.graph.edges.end(),
                              edges_.begin() + static_cast<std::ptrdiff_t>(edges_begun_), edges_.end());
  edges_ = std::move(solution.graph.edges);
  waiting_ = std::move(solution.waiting);
  const auto most = static_cast<std::size_t>(settings_.max_waiting);
  if (waiting_.size() > most) waiting_.erase(waiting_.begin(), waiting_.end() - settings_.max_waiting);
  solved_ = std::move(solution.graph.poses);
  solved_errors_ = std::move(solution.errors);
  solved_map_errors_ = std::move(solution.map_errors);
  solved_factors_ = solution.factors;
}

// A pose that the work has not moved yet is as wrong as it was.
void KeyframeGraph::adopt_errors() {
  if (solved_errors_.empty() || solved_map_errors_.size() != solved_errors_.size()) return;
  factors_ = solved_factors_;
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    if (i < solved_errors_.size()) {
      nodes_[i].error = solved_errors_[i];
      nodes_[i].map_error = solved_map_errors_[i];
    } else {
      carry_error(i);
    }
  solved_errors_.clear();
  solved_map_errors_.clear();
}

// From the node before, along the edge that tracking made; and it stands on the same ground.
void KeyframeGraph::carry_error(std::size_t node) {
  const auto to = static_cast<int>(node);
  for (auto e = edges_.rbegin(); e != edges_.rend(); ++e) {
    if (e->kind != EdgeKind::odometry || e->to != to) continue;
    const Node& before = nodes_[static_cast<std::size_t>(e->from)];
    const UncertainTransform step{before.T_world_camera.inverse() * nodes_[node].T_world_camera,
                                  edge_error(*e, settings_.optimiser, factors_)};
    const auto carried = [&](const PoseError& error) {
      const PoseError beside = carried_along(error, step);
      if (!ground_) return beside;
      GroundConstraint ground = *ground_;
      ground.floors.assign(1, nodes_[node].floor);
      return on_ground(beside, nodes_.front().T_world_camera.inverse() * nodes_[node].T_world_camera, ground,
                       settings_.optimiser, factors_);
    };
    nodes_[node].error = carried(before.error);
    nodes_[node].map_error = carried(before.map_error);
    return;
  }
}

std::optional<KeyframeGraph::Correction> KeyframeGraph::notable_correction(double min_translation,
                                                                           double min_rotation) const {
  Correction correction;
  bool notable = false;
  for (std::size_t i = 0; i < solved_.size(); ++i) {
    const Eigen::Isometry3d step = nodes_[i].T_world_camera.inverse() * solved_[i];
    notable = notable || step.translation().norm() > min_translation || rotation_angle(step) > min_rotation;
    correction.push_back(rigid(solved_[i] * nodes_[i].T_world_camera.inverse()));
  }
  return notable ? std::make_optional(correction) : std::nullopt;
}

std::optional<KeyframeGraph::Correction> KeyframeGraph::work(Utime now) {
  if (running_.valid()) {
    if (now < due_) return std::nullopt;
    take(running_.get());
    auto correction = notable_correction(settings_.min_translation, settings_.min_rotation);
    if (!correction) adopt_errors();
    return correction;
  }
  const auto ready = [&](const NewNode& added) {
    return !added.view->features.features.empty() ||
           now - added.utime >= static_cast<Utime>(1e6 * settings_.wait);
  };
  if (!fresh_.empty() && std::all_of(fresh_.begin(), fresh_.end(), ready)) begin(now, Optimise::new_circles);
  return std::nullopt;
}

std::optional<KeyframeGraph::Correction> KeyframeGraph::finish() {
  if (running_.valid()) take(running_.get());
  if (!settings_.enabled || nodes_.size() < 2) return std::nullopt;
  begin(0, Optimise::any_circle);
  take(running_.get());
  auto correction = notable_correction(least_correction, least_correction);
  if (!correction) adopt_errors();
  return correction;
}

std::optional<KeyframeGraph::Thinned> KeyframeGraph::thin(const Covering& covering) {
  const auto most = static_cast<std::size_t>(settings_.max_keyframes);
  const std::size_t newest = std::min<std::size_t>(10, most / 2);  // tracking and the next edges start there
  const auto keyframes = static_cast<std::size_t>(
      std::count_if(nodes_.begin(), nodes_.end(), [](const Node& n) { return n.keyframe; }));
  const std::size_t others = nodes_.size() - keyframes;
  const std::size_t most_others = std::min(most, std::max(others_at_least, keyframes));
  if (running_.valid() || (keyframes <= most && others <= most_others)) return std::nullopt;

  std::vector<ThinningNode> nodes;
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    nodes.push_back({nodes_[i].T_world_camera, nodes_[i].keyframe, i == 0 || i + newest >= nodes_.size()});
  for (const NewNode& added : fresh_) nodes[static_cast<std::size_t>(added.view->node)].fixed = true;
  const auto left = [](std::size_t count, std::size_t limit) {
    return count > limit ? limit - std::max<std::size_t>(1, limit / 10) : count;
  };
  Thinned thinned;
  thinned.gone = covered_nodes(nodes, left(keyframes, most), left(others, most_others), covering);
  if (std::none_of(thinned.gone.begin(), thinned.gone.end(), [](bool gone) { return gone; }))
    return std::nullopt;

  for (std::size_t i = 0; i < nodes_.size(); ++i)
    if (thinned.gone[i]) marginalise(static_cast<int>(i), edges_, waiting_);
  edges_ = surest_edges(edges_, nodes_.size(), edges_of_a_kind);
  std::vector<int> place(nodes_.size(), 0);
  std::vector<Node> kept;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    place[i] = static_cast<int>(kept.size());
    if (!thinned.gone[i]) kept.push_back(nodes_[i]);
  }
  for (const int successor : successors(nodes, thinned.gone, covering))
    thinned.index.push_back(place[static_cast<std::size_t>(successor)]);
  nodes_ = std::move(kept);
  for (auto* edges : {&edges_, &waiting_})
    for (GraphEdge& e : *edges) {
      e.from = place[static_cast<std::size_t>(e.from)];
      e.to = place[static_cast<std::size_t>(e.to)];
    }
  for (NewNode& added : fresh_) {
    added.view->node = place[static_cast<std::size_t>(added.view->node)];
    for (int& other : added.view->shows) other = thinned.index[static_cast<std::size_t>(other)];
  }
  finder_.renumber(thinned.gone, thinned.index);
  solved_.clear();
  solved_errors_.clear();
  solved_map_errors_.clear();
  return thinned;
}

std::size_t KeyframeGraph::memory_bytes() const {
  std::size_t bytes = nodes_.capacity() * sizeof(Node) + solved_.capacity() * sizeof(solved_[0]) +
                      (solved_errors_.capacity() + solved_map_errors_.capacity()) * sizeof(PoseError) +
                      (edges_.capacity() + waiting_.capacity()) * sizeof(GraphEdge);
  for (const NewNode& added : fresh_) bytes += lcmslam::memory_bytes(*added.view);
  return bytes + (running_.valid() ? finder_bytes_ : finder_.memory_bytes());
}

bool KeyframeGraph::ties(const std::vector<int>& first_ids) const {
  constexpr double known = 0.3;  // m, rad: more than that is where odometry led
  const auto part_of = [&](int node) {
    const int id = nodes_[static_cast<std::size_t>(node)].id;
    return static_cast<std::size_t>(std::upper_bound(first_ids.begin(), first_ids.end(), id) -
                                    first_ids.begin());
  };
  std::vector<std::size_t> tied_to(first_ids.size() + 1);  // by part: another of its group, or itself
  std::iota(tied_to.begin(), tied_to.end(), std::size_t{0});
  const auto group_of = [&](std::size_t part) {
    while (tied_to[part] != part) part = tied_to[part] = tied_to[tied_to[part]];
    return part;
  };
  for (const GraphEdge& e : edges_) {
    if (e.kind == EdgeKind::odometry || e.T_from_to.covariance.diagonal().maxCoeff() >= known * known)
      continue;
    tied_to[group_of(part_of(e.from))] = group_of(part_of(e.to));
  }
  return group_of(0) == group_of(first_ids.size());
}

void KeyframeGraph::apply(const Correction& correction) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Eigen::Isometry3d& C = correction[std::min(i, correction.size() - 1)];
    nodes_[i].T_world_camera = rigid(C * nodes_[i].T_world_camera);
  }
  adopt_errors();
}

}  // namespace lcmslam
