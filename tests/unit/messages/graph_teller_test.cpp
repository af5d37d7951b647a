#include <lcmslam/messages/graph_teller.hpp>

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/messages/decode.hpp>
#include "tests/unit/messages/graph_samples.hpp"

namespace lcmslam {
namespace {

using testing::edge;
using ::testing::ElementsAre;
using testing::graph_of;
using testing::ids_of;
using testing::node;

/// As the wire carries it.
graph_t sent(graph_t message, std::int64_t seq) {
  message.seq = seq;
  const auto bytes = encode_message(message);
  return decode_message<graph_t>(bytes.data(), bytes.size());
}

/// A mapper's graph that lives: nodes come, move a little or much and go, edges come, go and are merged.
class LivingGraph {
 public:
  graph_t whole() const {
    std::vector<graph_node_t> nodes;
    for (const auto& [id, T] : poses_) {
      nodes.push_back(node(id, 0));
      nodes.back().T_map_camera = to_message(T);
    }
    return graph_of(0, std::move(nodes), edges_);
  }

  void live(Random& random) {
    const double step = random.uniform() < 0.5 ? 0.0003 : 0.01;  // m, rad
    if (random.uniform() < 0.5)
      for (auto& [id, T] : poses_) {
        Vector6d twist;
        for (int i = 0; i < 6; ++i) twist(i) = random.uniform(-step, step);
        T = T * se3_exp(twist);
      }
    if (poses_.size() > 12 && random.uniform() < 0.4) remove(any(random));
    if (!edges_.empty() && random.uniform() < 0.3)
      edges_.erase(edges_.begin() + static_cast<std::ptrdiff_t>(random.below(edges_.size())));
    if (!edges_.empty() && random.uniform() < 0.3)
      edges_[random.below(edges_.size())].T_from_to.trans[1] += 0.1;
    for (graph_edge_t& e : edges_) e.error += 0.1F;
    const std::int32_t id = next_id_++;
    if (id > 0) {
      edges_.push_back(edge(poses_.rbegin()->first, id, 0, random.uniform()));
      edges_.push_back(edge(poses_.rbegin()->first, id, 1, random.uniform()));
      const std::int32_t other = any(random);
      edges_.push_back(edge(other, id, 2, random.uniform()));
    }
    poses_[id] =
        Eigen::Translation3d(random.uniform(-5, 5), random.uniform(-5, 5), 1) * Eigen::Isometry3d::Identity();
  }

 private:
  std::int32_t any(Random& random) const {
    return std::next(poses_.begin(), static_cast<std::ptrdiff_t>(random.below(poses_.size())))->first;
  }
  void remove(std::int32_t id) {
    poses_.erase(id);
    edges_.erase(std::remove_if(edges_.begin(), edges_.end(),
                                [&](const graph_edge_t& e) { return e.from_node == id || e.to_node == id; }),
                 edges_.end());
  }

  std::map<std::int32_t, Eigen::Isometry3d> poses_;
  std::vector<graph_edge_t> edges_;
  std::int32_t next_id_ = 0;
};

/// All of an edge but its error.
using EdgeKey = std::tuple<int, int, int, double, double>;
template <class Edges, class Get>
std::multiset<EdgeKey> keys(const Edges& edges, const Get& get) {
  std::multiset<EdgeKey> all;
  for (const auto& item : edges) {
    const graph_edge_t& e = get(item);
    all.insert({e.from_node, e.to_node, e.kind, e.T_from_to.trans[0], e.T_from_to.trans[1]});
  }
  return all;
}

void expect_equal(const FollowedGraph& followed, const graph_t& whole) {
  ASSERT_EQ(followed.nodes().size(), whole.nodes.size());
  for (const graph_node_t& n : whole.nodes) {
    ASSERT_EQ(followed.nodes().count(n.keyframe), 1U) << n.keyframe;
    const Eigen::Isometry3d step = from_message(n.T_map_camera, "now").inverse() *
                                   from_message(followed.nodes().at(n.keyframe).T_map_camera, "followed");
    EXPECT_LE(step.translation().norm(), GraphTeller::least_translation + 1e-12);
    EXPECT_LE(rotation_angle(step), GraphTeller::least_rotation + 1e-7);
  }
  EXPECT_EQ(keys(followed.edges(), [](const auto& item) { return item.second; }),
            keys(whole.edges, [](const graph_edge_t& e) { return e; }));
}

TEST(GraphTeller, AllChangesInTheirOrderMakeTheWholeGraph) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    LivingGraph graph;
    GraphTeller teller;
    FollowedGraph followed;
    std::size_t told = 0, whole = 0;
    for (int i = 0; i < 120; ++i) {
      graph.live(random);
      const graph_t message = sent(teller.tell(graph.whole(), false), i);
      EXPECT_EQ(message.change, i == 0 ? 0 : 1);
      followed.apply(message);
      ASSERT_TRUE(followed.complete());
      expect_equal(followed, graph.whole());
      told += encode_message(message).size();
      whole += encode_message(graph.whole()).size();
    }
    EXPECT_LT(3 * told, 2 * whole);
  }
}

TEST(GraphTeller, NothingIsToldTwice) {
  GraphTeller teller;
  const std::vector<graph_edge_t> edges = {edge(0, 1, 0), edge(0, 1, 1)};
  EXPECT_EQ(teller.tell(graph_of(0, {node(0, 0), node(1, 1)}, edges), false).change, 0);
  const auto is_empty = [](const graph_t& m) {
    return m.change == 1 && m.nodes.empty() && m.edges.empty() && m.gone.empty() && m.cut_from.empty();
  };
  EXPECT_TRUE(is_empty(teller.tell(graph_of(0, {node(0, 0), node(1, 1)}, edges), false)));
  // Slowly away from where it was told, and then no longer the same.
  EXPECT_TRUE(is_empty(teller.tell(graph_of(0, {node(0, 0), node(1, 1.0003)}, edges), false)));
  graph_t moved = teller.tell(graph_of(0, {node(0, 0), node(1, 1.0006)}, edges), false);
  ASSERT_EQ(moved.nodes.size(), 1U);
  EXPECT_EQ(moved.nodes[0].keyframe, 1);
  EXPECT_EQ(moved.n_nodes, 1);
  EXPECT_TRUE(is_empty(teller.tell(graph_of(0, {node(0, 0), node(1, 1.0006)}, edges), false)));

  std::vector<graph_edge_t> judged = edges;
  judged[0].error = 3;
  EXPECT_TRUE(is_empty(teller.tell(graph_of(0, {node(0, 0), node(1, 1.0006)}, judged), false)));
  graph_node_t turned = node(1, 1.0006);
  turned.T_map_camera = to_message(planar_pose(1.0006, 0, 0.0006));
  EXPECT_EQ(teller.tell(graph_of(0, {node(0, 0), turned}, edges), false).nodes.size(), 1U);

  const graph_t refused = teller.tell(graph_of(0, {node(0, 0), turned}, {}), false);
  EXPECT_THAT(refused.cut_from, ElementsAre(0));
  EXPECT_THAT(refused.cut_to, ElementsAre(1));
  const graph_t gone = teller.tell(graph_of(0, {node(0, 0)}, {}), false);
  EXPECT_THAT(gone.gone, ElementsAre(1));
  EXPECT_TRUE(is_empty(teller.tell(graph_of(0, {node(0, 0)}, {}), false)));
}

TEST(GraphTeller, TellsAllOfANewMapAndWhenAsked) {
  GraphTeller teller;
  teller.tell(graph_of(0, {node(0, 0)}, {}), false);
  const graph_t asked = teller.tell(graph_of(0, {node(0, 0.0001), node(1, 1)}, {}), true);
  EXPECT_EQ(asked.change, 0);
  EXPECT_EQ(asked.nodes.size(), 2U);
  EXPECT_EQ(asked.nodes[0].T_map_camera.trans[0], 0.0001);
  EXPECT_TRUE(teller.tell(graph_of(0, {node(0, 0.0005), node(1, 1)}, {}), false).nodes.empty());
  graph_t beside = graph_of(0, {node(0, 0)}, {});
  beside.frame = "map-2";
  EXPECT_EQ(teller.tell(beside, false).change, 0);
  EXPECT_EQ(teller.tell(beside, false).change, 1);
}

TEST(GraphTeller, ALostMessageIsRepairedByTheWholeGraph) {
  Random random(3);
  LivingGraph graph;
  GraphTeller teller;
  FollowedGraph followed;
  for (int i = 0; i < 40; ++i) {
    graph.live(random);
    const graph_t message = sent(teller.tell(graph.whole(), i == 30), i);
    if (i == 20) continue;  // nobody hears it
    followed.apply(message);
    EXPECT_EQ(followed.complete(), i < 20 || i >= 30);
    if (followed.complete()) expect_equal(followed, graph.whole());
  }
}

}  // namespace
}  // namespace lcmslam
