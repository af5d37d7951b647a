// What is told at another pace must lead to the same map.

#include "procs/bridge/map_tellers.hpp"

#include <gmock/gmock.h>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/map_messages.hpp>

namespace lcmslam {
namespace {

Landmark some_landmark(Random& random, std::int64_t id) {
  Landmark landmark;
  landmark.id = id;
  landmark.mean = {random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(0, 2)};
  landmark.observations = static_cast<int>(random.below(100));
  return landmark;
}

/// A mapper that changes a few landmarks at a time.
class Mapper {
 public:
  landmarks_t change() {
    const std::int64_t base = revision_;
    std::vector<Landmark> upserted;
    std::vector<std::int64_t> removed;
    for (int i = 0; i < 5; ++i) {
      const auto id = static_cast<std::int64_t>(random_.below(60));
      if (landmarks_.count(id) > 0 && random_.below(4) == 0) {
        landmarks_.erase(id);
        removed.push_back(id);
      } else if (std::find(removed.begin(), removed.end(), id) == removed.end()) {
        landmarks_[id] = some_landmark(random_, id);
      }
    }
    for (const auto& [id, landmark] : landmarks_) upserted.push_back(landmark);
    landmarks_t message = make_landmark_tiles(++utime_, ++revision_, base, upserted, removed).front();
    message.sender = 5;
    return message;
  }
  std::map<std::int64_t, Landmark> landmarks_;

 private:
  Random random_{1};
  std::int64_t revision_ = 0;
  Utime utime_ = 0;
};

void apply(LandmarkMap& map, const landmarks_t& message) {
  map.apply({message.map_revision, message.base_revision, landmarks_of(message), message.removed});
}

void expect_equal(const LandmarkMap& map, const std::map<std::int64_t, Landmark>& truth) {
  ASSERT_EQ(map.size(), truth.size());
  EXPECT_FALSE(map.incomplete());
  for (const auto& [id, landmark] : truth) {
    ASSERT_NE(map.find(id), nullptr) << id;
    EXPECT_EQ(map.find(id)->mean, landmark.mean) << id;
    EXPECT_EQ(map.find(id)->observations, landmark.observations) << id;
  }
}

TEST(LandmarkTeller, TenChangesToldAtOnceLeadToTheSameMap) {
  Mapper mapper;
  LandmarkTeller teller;
  LandmarkMap told;
  for (int i = 0; i < 200; ++i) {
    teller.hear(mapper.change());
    if (i % 10 != 9) continue;
    const auto message = teller.tell(i % 50 == 49);
    ASSERT_TRUE(message);
    EXPECT_EQ(message->base_revision == 0, i == 9 || i % 50 == 49);
    EXPECT_EQ(message->sender, 5);
    apply(told, *message);
    expect_equal(told, mapper.landmarks_);
    EXPECT_FALSE(teller.tell(false)) << "nothing new";
  }
}

TEST(LandmarkTeller, SaysWhenItMissedSomethingAndTellsNothingUntilItHasAll) {
  Mapper mapper;
  LandmarkTeller teller;
  teller.hear(mapper.change());
  ASSERT_TRUE(teller.tell(false));
  mapper.change();  // lost
  teller.hear(mapper.change());
  EXPECT_TRUE(teller.incomplete());
  EXPECT_FALSE(teller.tell(true));
  std::vector<Landmark> all;
  for (const auto& [id, landmark] : mapper.landmarks_) all.push_back(landmark);
  landmarks_t whole = make_landmark_tiles(10, 3, 0, all, {}).front();
  whole.sender = 5;
  teller.hear(whole);
  EXPECT_FALSE(teller.incomplete());
  LandmarkMap told;
  apply(told, teller.tell(true).value());
  expect_equal(told, mapper.landmarks_);
}

TEST(LandmarkTeller, AnotherMapIsToldWhole) {
  Mapper first, second;
  LandmarkTeller teller;
  teller.hear(first.change());
  teller.tell(false);
  landmarks_t other = second.change();
  other.sender = 6;
  teller.hear(other);
  const auto message = teller.tell(false);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->base_revision, 0);
  EXPECT_EQ(teller.sender(), 6);
}

graph_t graph_of(const std::map<int, double>& nodes) {
  graph_t graph{};
  for (const auto& [id, x] : nodes) {
    graph_node_t node{};
    node.keyframe = id;
    node.T_map_camera.trans[0] = x;
    node.T_map_camera.quat[0] = 1;
    graph.nodes.push_back(node);
  }
  graph.n_nodes = static_cast<std::int32_t>(graph.nodes.size());
  graph.frame = "map";
  graph.sender = 9;
  return graph;
}

// The broker keeps what was told of each until it is told otherwise, also where the whole graph says so.
TEST(GraphRelay, KnowsWhatWasGivenUpHoweverItTells) {
  for (const bool whole : {false, true}) {
    GraphRelay relay;
    relay.hear(graph_of({{1, 0}, {2, 1}, {3, 2}}));
    relay.tell(false);
    EXPECT_TRUE(relay.gone().empty());
    relay.hear(graph_of({{1, 0}, {4, 3}}));
    ASSERT_TRUE(relay.tell(whole));
    EXPECT_EQ(relay.gone(), (std::vector<std::int32_t>{2, 3})) << whole;
    ASSERT_TRUE(relay.tell(true));
    EXPECT_TRUE(relay.gone().empty()) << "told once";
  }
}

TEST(GraphRelay, TellsWhatChangedSinceItToldLast) {
  GraphRelay relay;
  FollowedGraph told;
  EXPECT_FALSE(relay.tell(true));
  std::map<int, double> nodes;
  for (int i = 0; i < 30; ++i) {
    nodes[i] = i;
    if (i % 7 == 6) nodes.erase(i - 3);
    nodes.begin()->second += 0.1;
    graph_t message = graph_of(nodes);
    message.seq = i;
    relay.hear(message);
    if (i % 5 != 4) continue;
    const auto change = relay.tell(i == 14);
    ASSERT_TRUE(change);
    EXPECT_EQ(change->change, i == 4 || i == 14 ? 0 : 1);
    EXPECT_EQ(change->sender, 9);
    told.apply(*change);
    EXPECT_TRUE(told.complete());
    ASSERT_EQ(told.nodes().size(), nodes.size());
    for (const auto& [id, x] : nodes) EXPECT_EQ(told.nodes().at(id).T_map_camera.trans[0], x);
    EXPECT_FALSE(relay.tell(false)) << "nothing new";
  }
}

}  // namespace
}  // namespace lcmslam
