#include <lcmslam/messages/followed_graph.hpp>

#include <gmock/gmock.h>

#include "tests/unit/messages/graph_samples.hpp"

namespace lcmslam {
namespace {

using testing::edge;
using ::testing::ElementsAre;
using testing::graph_of;
using testing::ids_of;
using testing::node;

graph_t change_of(std::int64_t seq, std::vector<graph_node_t> nodes, std::vector<graph_edge_t> edges,
                  std::vector<std::int32_t> gone = {}) {
  graph_t m = graph_of(seq, std::move(nodes), std::move(edges));
  m.change = 1;
  m.gone = std::move(gone);
  m.n_gone = static_cast<std::int32_t>(m.gone.size());
  return m;
}

std::vector<std::pair<FollowedGraph::Pair, int>> edges_of(const FollowedGraph& graph) {
  std::vector<std::pair<FollowedGraph::Pair, int>> all;
  for (const auto& [pair, e] : graph.edges()) all.emplace_back(pair, e.kind);
  return all;
}

TEST(FollowedGraph, ChangesBuildOnAWholeGraph) {
  FollowedGraph graph;
  EXPECT_TRUE(graph.complete()) << "nothing was missed";
  graph.apply(
      graph_of(7, {node(0, 0), node(1, 1), node(2, 2)}, {edge(0, 1, 0), edge(1, 2, 0), edge(0, 2, 1)}));
  graph_t m = change_of(8, {node(1, 1.5), node(3, 3)}, {edge(2, 3, 0), edge(2, 3, 1)});
  m.map_revision = 4;
  graph.apply(m);
  EXPECT_TRUE(graph.complete());
  EXPECT_EQ(graph.map_revision(), 4);
  EXPECT_THAT(ids_of(graph), ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(graph.poses().at(1).T_world_camera.translation().x(), 1.5);
  EXPECT_EQ(graph.edges().size(), 5U);

  m = change_of(9, {}, {edge(2, 3, 2)}, {1});  // with its edges; those between 2 and 3 are told anew
  m.n_cut = 1;
  m.cut_from = {0};
  m.cut_to = {2};
  graph.apply(m);
  EXPECT_THAT(ids_of(graph), ElementsAre(0, 2, 3));
  EXPECT_THAT(edges_of(graph), ElementsAre(std::pair(FollowedGraph::Pair(2, 3), 2)));
  graph.apply(graph_of(2, {node(5, 0)}, {}));  // whole, whatever its number
  EXPECT_THAT(ids_of(graph), ElementsAre(5));
  EXPECT_TRUE(graph.edges().empty());
}

TEST(FollowedGraph, KnowsWhenItMissedAMessageUntilTheWholeGraphComes) {
  FollowedGraph graph;
  graph.apply(graph_of(7, {node(0, 0)}, {}));
  graph.apply(change_of(9, {node(2, 2)}, {}));
  EXPECT_FALSE(graph.complete());
  EXPECT_THAT(ids_of(graph), ElementsAre(0, 2)) << "it goes on with what it has";
  graph.apply(change_of(8, {node(0, 9)}, {}));  // late
  EXPECT_EQ(graph.poses().at(0).T_world_camera.translation().x(), 0);
  graph.apply(change_of(10, {node(3, 3)}, {}));
  EXPECT_FALSE(graph.complete());
  graph.apply(graph_of(11, {node(0, 0), node(1, 1)}, {}));
  EXPECT_TRUE(graph.complete());
  EXPECT_THAT(ids_of(graph), ElementsAre(0, 1));
  graph.apply(change_of(12, {node(2, 2)}, {}));
  graph.apply(change_of(12, {node(7, 7)}, {}));  // the number came twice
  EXPECT_TRUE(graph.complete());
  EXPECT_THAT(ids_of(graph), ElementsAre(0, 1, 2));
}

TEST(FollowedGraph, WhoeverJoinsLateHasMissedTheBeginning) {
  FollowedGraph graph;
  graph.apply(change_of(0, {node(5, 5)}, {}));
  EXPECT_FALSE(graph.complete());
}

TEST(FollowedGraph, RefusesWhatIsNoPoseAndStaysAsItWas) {
  FollowedGraph graph;
  graph.apply(graph_of(0, {node(0, 0)}, {}));
  EXPECT_THROW(graph.apply(change_of(1, {node(1, std::nan(""))}, {}, {0})), DecodeError);
  EXPECT_THROW(graph.apply(graph_of(1, {node(1, std::nan(""))}, {})), DecodeError);
  EXPECT_THAT(ids_of(graph), ElementsAre(0));
  EXPECT_TRUE(graph.complete());
}

TEST(FollowedGraph, IsBounded) {
  FollowedGraph graph;
  graph.apply(graph_of(0, {}, {}));
  std::int64_t seq = 0;
  std::int32_t id = 0;
  for (int i = 0; i < 4; ++i) {
    std::vector<graph_node_t> nodes(25'000, node(0, 0));
    for (graph_node_t& n : nodes) n.keyframe = id++;
    graph.apply(change_of(++seq, nodes, {}));
  }
  EXPECT_THROW(graph.apply(change_of(++seq, {node(id, 0)}, {})), DecodeError);
  EXPECT_EQ(graph.nodes().size(), 100'000U);
}

DenseKeyframe keyframe(std::int32_t id) {
  DenseKeyframe k;
  k.id = id;
  k.cloud.points = {{0, 0, 1}};
  k.cloud.colours = {{1, 2, 3}};
  return k;
}

// A broker keeps whole graphs of once in a while, and keyframes as they are made.
TEST(FollowedGraph, SaysNothingOfKeyframesThatWereMadeLater) {
  FollowedGraph graph;
  DenseMap map;
  for (std::int32_t id = 0; id < 4; ++id) {
    DenseKeyframe made = keyframe(id);
    made.utime = 1000 + id;
    map.add({made, 0, 1});
  }
  const auto tell = [&](graph_t m, Utime utime) {
    m.utime = utime;
    graph.apply(m);
    follow(map, graph, m);
    return map.keyframes().size();
  };
  EXPECT_EQ(tell(graph_of(7, {node(1, 1), node(2, 2)}, {}), 1002), 3U) << "0 went, 3 is newer";
  EXPECT_EQ(tell(change_of(8, {node(2, 2.5)}, {}), 1004), 2U) << "by then it was known";
}

TEST(FollowedGraph, MovesAndRemovesKeyframes) {
  FollowedGraph graph;
  DenseMap map;
  const auto tell = [&](const graph_t& m) {
    graph.apply(m);
    follow(map, graph, m);
  };
  const auto x_of = [&](std::int32_t id) { return map.keyframes().at(id).T_world_camera.translation().x(); };
  tell(graph_of(0, {node(0, 0), node(1, 1), node(2, 2), node(3, 3)}, {}));
  for (std::int32_t id = 0; id < 4; ++id) map.add({keyframe(id), 0, 1});  // with the poses of long ago
  tell(change_of(1, {node(1, 1.25)}, {}));
  EXPECT_EQ(x_of(1), 1.25);
  EXPECT_EQ(x_of(2), 2) << "what was told before holds, too";
  tell(change_of(2, {}, {}, {3}));
  EXPECT_EQ(map.keyframes().size(), 3U);
  map.add({keyframe(9), 0, 1});
  tell(change_of(4, {node(2, 2.5)}, {}, {1}));  // 3 is missing: 9 may have been told by it
  EXPECT_EQ(map.keyframes().count(9), 1U);
  EXPECT_EQ(map.keyframes().count(1), 0U);
  EXPECT_EQ(x_of(2), 2.5);
  tell(graph_of(5, {node(0, 0), node(2, 2)}, {}));
  EXPECT_EQ(map.keyframes().size(), 2U);
}

}  // namespace
}  // namespace lcmslam
