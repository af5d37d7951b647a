// Mappers that begin anew, take a map away, or are not who they say: maps stay beside each other.

#include <lcmslam/map_store/map_export.hpp>
#include "tests/unit/nodes/map_server_fixture.hpp"

namespace lcmslam {
namespace {

using testing::MapServer;
using testing::value_of;

TEST_F(MapServer, ChangesThatTakeTheMostOfAMapAwayLeaveItBeside) {
  for (int id = 0; id < 5; ++id) keyframe(2, id, 10);
  graph_t m = graph_message(2, {0, 1, 2, 3, 4}, 5);
  m.seq = 0;
  bus_.deliver("ICP_GRAPH", m);
  m = graph_message(2, {}, 2);
  m.seq = 1;
  m.change = 1;
  m.gone = {0, 1, 2};
  m.n_gone = 3;
  bus_.deliver("ICP_GRAPH", m);
  EXPECT_EQ(value_of(node_, "keyframes"), 2);
  EXPECT_EQ(value_of(node_, "sessions"), 2);
}

TEST_F(MapServer, WhoeverTakesTheMostOfAMapAwayLeavesItBeside) {
  for (int id = 0; id < 5; ++id) keyframe(2, id, 10);
  graph(2, {}, 0);
  EXPECT_EQ(value_of(node_, "keyframes"), 0);
  landmarks(1, 1, 0, {10, 11, 12, 13, 14});
  landmarks(1, 2, 1, {}, {10, 11, 12, 13, 14});
  landmarks(1, 3, 2, {20, 21, 22, 23, 24, 25});
  landmarks(1, 4, 0, {30});
  EXPECT_EQ(value_of(node_, "landmarks"), 1);
  EXPECT_EQ(value_of(node_, "sessions"), 3);
  EXPECT_EQ(request(map_request_t::EXPORT, "maps", "ply").status, 0);
  EXPECT_EQ(load_ply(folder() / "icp-session2_map.ply").size(), 50U);
  EXPECT_EQ(load_ply(folder() / "fastslam-session2_map.ply").size(), 5U);
  EXPECT_EQ(load_ply(folder() / "fastslam-session3_map.ply").size(), 6U);
}

// As a broker keeps it: whole graphs go there once in a while, keyframes as they are made.
TEST_F(MapServer, AGraphThatIsOlderThanMostKeyframesTakesNoneOfThemAway) {
  for (int id = 4; id >= 0; --id) keyframe(2, id, 10);
  graph(2, {0, 1});
  EXPECT_EQ(value_of(node_, "keyframes"), 5);
  EXPECT_EQ(value_of(node_, "sessions"), 1);
  graph_t now = graph_message(2, {0, 2, 3}, 3);
  now.utime = 10'000'000;
  now.seq = seq_++;
  bus_.deliver("ICP_GRAPH", now);
  EXPECT_EQ(value_of(node_, "keyframes"), 3) << "it was told after all of them";
}

// The next mapper's poses are believed once the last one has been silent for a while.
TEST_F(MapServer, WhatARestartedMapperMakesBeforeItIsBelievedIsNoGarbage) {
  pose("FASTSLAM_POSE", 1, 0, 10);
  pose("ICP_POSE", 2, 0, 10);
  keyframe(2, 0, 30);
  pose("ICP_POSE", 4, 1, 10.1);
  keyframe(4, 0, 40);
  graph(4, {0});
  landmarks(3, 1, 0, {20});
  EXPECT_EQ(bus_.decode_errors(), 0);
  EXPECT_EQ(value_of(node_, "sessions_refused"), 3);
  EXPECT_EQ(value_of(node_, "map_points"), 30);
}

TEST_F(MapServer, NewSenderBeginsANewSessionBesideTheOld) {
  pose("FASTSLAM_POSE", 1, 0, 10);
  pose("ICP_POSE", 2, 0, 10);
  landmarks(1, 1, 0, {10, 11});
  keyframe(2, 0, 30);
  for (double seconds = 15; seconds < 16; seconds += 0.1) {  // both were killed, and come back
    pose("FASTSLAM_POSE", 3, 0, seconds);
    pose("ICP_POSE", 4, 0, seconds);
  }
  landmarks(3, 1, 0, {20});
  keyframe(4, 0, 40);
  EXPECT_EQ(value_of(node_, "sessions"), 2);
  EXPECT_EQ(value_of(node_, "landmarks"), 1);
  EXPECT_EQ(value_of(node_, "map_points"), 40);
  EXPECT_EQ(request(map_request_t::EXPORT, "maps", "ply").status, 0);
  EXPECT_EQ(load_ply(folder() / "fastslam-session1_map.ply").size(), 2U);
  EXPECT_EQ(load_ply(folder() / "fastslam_map.ply").size(), 1U);
  EXPECT_EQ(load_ply(folder() / "icp-session1_map.ply").size(), 30U);
  EXPECT_EQ(load_ply(folder() / "icp_map.ply").size(), 40U);
}

TEST_F(MapServer, AnotherFrameOfTheSameSenderIsAnotherSession) {
  pose("FASTSLAM_POSE", 1, 0, 10);
  landmarks(1, 1, 0, {10, 11, 12});
  pose("FASTSLAM_POSE", 1, 0, 10.1, "map-2");
  landmarks(1, 1, 0, {20}, {}, "map-2");
  EXPECT_EQ(value_of(node_, "sessions"), 2);
  EXPECT_EQ(value_of(node_, "landmarks"), 1);
  EXPECT_EQ(request(map_request_t::EXPORT, "maps", "ply").status, 0);
  EXPECT_EQ(load_ply(folder() / "fastslam-session1_map.ply").size(), 3U);
}

TEST_F(MapServer, InventedSendersDoNotTakeItOver) {
  for (int sender = 1000; sender < 1100; ++sender) landmarks(sender, 1, 0, {1});  // before any mapper speaks
  EXPECT_EQ(value_of(node_, "sessions"), 16);
  pose("FASTSLAM_POSE", 1, 0, 10);
  pose("ICP_POSE", 2, 0, 10);
  landmarks(1, 1, 0, {10, 11});
  keyframe(2, 0, 30);
  for (int sender = 2000; sender < 5000; ++sender) landmarks(sender, 1, 0, {1});
  for (int sender = 5000; sender < 6500; ++sender) {
    keyframe(sender, 0, 3);
    pose("ICP_POSE", sender, 9, 10.05);
  }
  EXPECT_EQ(value_of(node_, "sessions"), 16);
  EXPECT_EQ(value_of(node_, "sessions_refused"), 84 + 1 + 3000 + 1500);
  EXPECT_EQ(value_of(node_, "landmarks"), 2) << "the mapper that is alive is told first";
  EXPECT_EQ(value_of(node_, "map_points"), 30);
  EXPECT_EQ(bus_.stamps(0).foreign(), 1500);
  landmarks(1, 2, 1, {12});
  EXPECT_EQ(value_of(node_, "landmarks"), 3);
  EXPECT_EQ(request(map_request_t::EXPORT, "maps", "ply").status, 0);
  EXPECT_EQ(load_ply(folder() / "fastslam_map.ply").size(), 3U);
  EXPECT_FALSE(exists("fastslam-session17_map.ply"));
  EXPECT_FALSE(exists("icp-session1_map.ply"));
}

TEST_F(MapServer, TwoMappersAtOnceDoNotMultiplySessions) {
  for (int i = 0; i < 10; ++i) {
    landmarks(1, i + 1, i, {100 + i});
    landmarks(3, i + 1, i, {200 + i});
  }
  EXPECT_EQ(value_of(node_, "sessions"), 2);
  EXPECT_EQ(value_of(node_, "landmarks"), 10);
  EXPECT_EQ(resends("fastslam"), 0U);
}

}  // namespace
}  // namespace lcmslam
