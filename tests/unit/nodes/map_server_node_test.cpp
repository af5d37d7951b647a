// What the map server hears, and what it asks for again.

#include "tests/unit/nodes/map_server_fixture.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::MapServer;
using testing::value_of;

TEST_F(MapServer, InfoTellsWhatIsThere) {
  landmarks(1, 1, 0, {10, 11});
  keyframe(2, 0, 50);
  const auto text = [](const map_reply_t& reply) {
    return std::string(reply.data.begin(), reply.data.end());
  };
  EXPECT_THAT(text(request(map_request_t::INFO)),
              AllOf(HasSubstr("\"landmarks\": 2"), HasSubstr("\"keyframes\": 1")));
}

// Counting the points of a map that is put together of all keyframes takes seconds.
TEST_F(MapServer, InfoCountsThePointsThatStatusCounts) {
  for (std::int32_t id = 0; id < 20; ++id) keyframe(2, id, 2000);
  const map_reply_t reply = request(map_request_t::INFO);
  EXPECT_THAT(std::string(reply.data.begin(), reply.data.end()), HasSubstr("\"map_points\": 40000,"));
}

TEST_F(MapServer, MissedLandmarkChangeIsAskedForAgainAndRepaired) {
  landmarks(1, 1, 0, {10});
  pose("FASTSLAM_POSE", 1, 1, 10.0);
  landmarks(1, 3, 2, {12});  // the change from 1 to 2 is missing
  pose("FASTSLAM_POSE", 1, 3, 10.1);
  EXPECT_EQ(resends("fastslam"), 0U) << "it may still be under way";
  pose("FASTSLAM_POSE", 1, 3, 10.7);
  pose("FASTSLAM_POSE", 1, 3, 11.2);
  EXPECT_EQ(resends("fastslam"), 1U);
  pose("FASTSLAM_POSE", 1, 3, 11.3);
  EXPECT_EQ(resends("fastslam"), 1U) << "not with every message";
  landmarks(1, 4, 0, {10, 11, 12, 13});
  EXPECT_EQ(value_of(node_, "landmarks"), 4);
  landmarks(1, 5, 4, {14});
  EXPECT_EQ(value_of(node_, "landmarks"), 5);
  for (double seconds = 11.5; seconds < 20; seconds += 0.5) pose("FASTSLAM_POSE", 1, 5, seconds);
  EXPECT_EQ(value_of(node_, "resends_asked"), 1);
}

TEST_F(MapServer, AMapThatIsLateAllTheTimeIsNotAskedFor) {
  landmarks(1, 1, 0, {10});
  for (int i = 2; i < 40; ++i) {  // over a bridge: each change 0.8 s behind the pose that names it
    pose("FASTSLAM_POSE", 1, i, 10 + 0.4 * i);
    if (i > 3) landmarks(1, i - 2, i - 3, {10 + i});
  }
  EXPECT_EQ(resends("fastslam"), 0U);
}

TEST_F(MapServer, WhoDoesNotAnswerIsAskedLessAndLess) {
  for (int i = 0; i < 600; ++i) pose("ICP_POSE", 2, 7, 10 + 0.1 * i);
  EXPECT_GT(resends("icp"), 3U);
  EXPECT_LT(resends("icp"), 7U) << "a minute at twice the pause each time";
}

TEST_F(MapServer, KeyframesThatDoNotComeAreAskedForAgain) {
  keyframe(2, 0, 10);
  pose("ICP_POSE", 2, 1, 10.0);
  pose("ICP_POSE", 2, 2, 10.1);  // the newest still comes
  EXPECT_EQ(resends("icp"), 0U);
  pose("ICP_POSE", 2, 2, 11.1);
  EXPECT_EQ(resends("icp"), 1U);
  keyframe(2, 1, 10);
  pose("ICP_POSE", 2, 2, 15.0);
  EXPECT_EQ(resends("icp"), 1U);
}

// Poses count the keyframes that were made, graphs those that are kept.

TEST_F(MapServer, RedundantKeyframesThatWentAreNotAskedFor) {
  for (int id = 0; id < 5; ++id) keyframe(2, id, 10);
  graph(2, {0, 2, 4}, 3);
  for (double seconds = 10; seconds < 20; seconds += 0.5) pose("ICP_POSE", 2, 5, seconds);
  EXPECT_EQ(resends("icp"), 0U);
  keyframe(2, 5, 10);
  graph(2, {0, 2, 4, 5, 6}, 5);  // 6 does not come
  for (double seconds = 20; seconds < 21.6; seconds += 0.5) pose("ICP_POSE", 2, 7, seconds);
  EXPECT_EQ(resends("icp"), 1U);
}

TEST_F(MapServer, AGraphThatMissedAChangeIsAskedForAgainAndRepaired) {
  for (int id = 0; id < 4; ++id) keyframe(2, id, 10);
  pose("ICP_POSE", 2, 4, 9.0);
  const auto tell = [&](std::int64_t seq, bool change, const std::vector<std::int32_t>& ids,
                        const std::vector<std::int32_t>& gone) {
    graph_t m = graph_message(2, ids, 4 - static_cast<std::int64_t>(gone.size()));
    m.seq = seq;
    m.change = change ? 1 : 0;
    m.gone = gone;
    m.n_gone = static_cast<std::int32_t>(gone.size());
    bus_.deliver("ICP_GRAPH", m);
  };
  tell(0, false, {0, 1, 2, 3}, {});
  tell(1, true, {2}, {});
  EXPECT_EQ(value_of(node_, "keyframes"), 4) << "a change names only what moved";
  for (double seconds = 10; seconds < 15; seconds += 0.5) pose("ICP_POSE", 2, 4, seconds);
  EXPECT_EQ(resends("icp"), 0U);
  tell(3, true, {}, {3});  // 2 told that 1 is gone
  EXPECT_EQ(value_of(node_, "keyframes"), 3);
  for (double seconds = 15; seconds < 16.6; seconds += 0.5) pose("ICP_POSE", 2, 4, seconds);
  EXPECT_EQ(resends("icp"), 1U);
  tell(4, false, {0, 2}, {});
  EXPECT_EQ(value_of(node_, "keyframes"), 2);
  tell(5, true, {0}, {});
  for (double seconds = 17; seconds < 22; seconds += 0.5) pose("ICP_POSE", 2, 2, seconds);
  EXPECT_EQ(resends("icp"), 1U);
}

// The first graph comes before the first keyframe.

TEST_F(MapServer, TheFirstGraphIsRemembered) {
  graph_t m = graph_message(2, {0}, 1);
  m.seq = 0;
  bus_.deliver("ICP_GRAPH", m);
  keyframe(2, 0, 10);
  m = graph_message(2, {1}, 2);
  m.seq = 1;
  m.change = 1;
  bus_.deliver("ICP_GRAPH", m);
  keyframe(2, 1, 10);
  for (double seconds = 10; seconds < 15; seconds += 0.5) pose("ICP_POSE", 2, 2, seconds);
  EXPECT_EQ(value_of(node_, "keyframes"), 2);
  EXPECT_EQ(resends("icp"), 0U);
}

TEST_F(MapServer, ServerThatStartsLateAsksForTheWholeMap) {
  for (const double seconds : {100.0, 100.5, 101.0, 101.5}) pose("ICP_POSE", 2, 7, seconds);
  EXPECT_EQ(resends("icp"), 1U);
}

TEST_F(MapServer, KeyframesThatTheMapperGaveUpAreForgotten) {
  for (int id = 0; id < 4; ++id) keyframe(2, id, 10);
  graph(2, {0, 1, 2, 3});
  EXPECT_EQ(value_of(node_, "keyframes"), 4);
  graph(2, {0, 3});
  EXPECT_EQ(value_of(node_, "keyframes"), 2);
  EXPECT_EQ(value_of(node_, "map_points"), 20);
  EXPECT_EQ(value_of(node_, "sessions"), 1);
}

TEST_F(MapServer, IncompleteKeyframesAreBounded) {
  for (int id = 0; id < 200; ++id) {
    DenseKeyframe k = testing::some_keyframe(random_, 6000);
    k.id = id;
    keyframe_t first = make_keyframe_tiles(k, Eigen::Isometry3d::Identity(), 1).front();
    ASSERT_GT(first.n_tiles, 1);
    first.sender = 2;
    bus_.deliver("ICP_KEYFRAME", first);
  }
  EXPECT_EQ(value_of(node_, "keyframes_given_up"), 200 - 32);
  keyframe(2, 500, 6000);
  EXPECT_EQ(value_of(node_, "keyframes"), 1);
}

TEST_F(MapServer, ImpossibleMessagesAreCounted) {
  keyframe_t tile =
      make_keyframe_tiles(testing::some_keyframe(random_, 5), Eigen::Isometry3d::Identity(), 1).front();
  tile.tile = 9;
  bus_.deliver("ICP_KEYFRAME", tile);
  pose_estimate_t pose{};
  bus_.deliver("ICP_POSE", pose);  // a quaternion of zeros
  EXPECT_EQ(bus_.decode_errors(), 2);
  EXPECT_EQ(value_of(node_, "keyframes"), 0);
}

}  // namespace
}  // namespace lcmslam
