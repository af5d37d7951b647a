#include "procs/map-server/map_server_node.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include "tests/support/test_bus.hpp"
#include "tests/unit/messages/samples.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::value_of;

class MapServer : public ::testing::Test {
 protected:
  void landmarks(std::int64_t sender, std::int64_t revision, std::int64_t base,
                 const std::vector<std::int64_t>& ids, const std::vector<std::int64_t>& removed = {}) {
    std::vector<Landmark> upserted;
    for (const std::int64_t id : ids) upserted.push_back(testing::some_landmark(random_, id));
    for (landmarks_t& tile : make_landmark_tiles(1, revision, base, upserted, removed)) {
      tile.seq = seq_++;
      tile.sender = sender;
      bus_.deliver("FASTSLAM_LANDMARKS", tile);
    }
  }
  void keyframe(std::int64_t sender, std::int32_t id, std::size_t points) {
    DenseKeyframe k = testing::some_keyframe(random_, points);
    k.id = id;
    for (keyframe_t& tile : make_keyframe_tiles(k, Eigen::Isometry3d::Identity(), id + 1)) {
      tile.seq = seq_++;
      tile.sender = sender;
      bus_.deliver("ICP_KEYFRAME", tile);
    }
  }
  void graph(std::int64_t sender, const std::vector<std::int32_t>& ids, std::int64_t keyframes = 1) {
    graph_t m;
    m.utime = 1;
    m.map_revision = keyframes;
    m.seq = seq_++;
    m.sender = sender;
    for (const std::int32_t id : ids) {
      graph_node_t node;
      node.keyframe = id;
      node.keyframe_utime = 1;
      node.T_map_camera = to_message(Eigen::Isometry3d::Identity());
      m.nodes.push_back(node);
    }
    m.n_nodes = static_cast<int32_t>(ids.size());
    m.n_edges = 0;
    bus_.deliver("ICP_GRAPH", m);
  }
  /// A mapper's pose at `seconds`, measured against this revision of its map.
  void pose(const std::string& channel, std::int64_t sender, std::int64_t revision, double seconds) {
    pose_estimate_t m = make_pose_estimate(static_cast<Utime>(1e6 * seconds), Eigen::Isometry3d::Identity(),
                                           Matrix6d::Identity());
    m.seq = seq_++;
    m.sender = sender;
    m.map_revision = revision;
    bus_.deliver(channel, m);
  }
  map_reply_t request(std::int8_t kind, const std::string& argument = "", const std::string& format = "") {
    map_request_t m;
    m.utime = 5;
    m.seq = seq_++;
    m.sender = 77;
    m.request_id = 1000 + seq_;
    m.kind = kind;
    m.argument = argument;
    m.format = format;
    m.n_numbers = 0;
    bus_.deliver("MAP_REQUEST", m);
    const map_reply_t reply = bus_.on<map_reply_t>("MAP_REPLY").back();
    EXPECT_EQ(reply.request_id, m.request_id);
    return reply;
  }
  std::size_t resends(const std::string& process) const {
    std::size_t n = 0;
    for (const command_t& c : bus_.on<command_t>("COMMAND")) n += c.name == "resend" && c.target == process;
    return n;
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder() / name); }
  std::filesystem::path folder() const { return scratch_.path() / "maps"; }

  Random random_{1};
  testing::ScratchFolder scratch_;
  testing::TestBus bus_;
  MapServerNode& node_ =
      bus_.add<MapServerNode>(ConfigNode::parse("{folder: " + (scratch_.path() / "own").string() + "}"));
  std::int64_t seq_ = 0;
};

TEST_F(MapServer, TilesBecomeFiles) {
  landmarks(1, 1, 0, {10, 11, 12});
  landmarks(1, 2, 1, {13}, {11});
  keyframe(2, 0, 6000);  // more than one tile
  keyframe(2, 1, 100);
  EXPECT_EQ(value_of(node_, "landmarks"), 3);
  EXPECT_EQ(value_of(node_, "keyframes"), 2);
  EXPECT_EQ(value_of(node_, "map_points"), 6100);
  const map_reply_t reply = request(map_request_t::EXPORT, folder().string());
  EXPECT_EQ(reply.status, 0) << reply.message;
  for (const std::string mapper : {"fastslam", "icp"})
    for (const std::string suffix : {"_map.ply", "_map.pcd", "_front.png", "_top.png"}) {
      EXPECT_TRUE(exists(mapper + suffix)) << mapper + suffix;
      EXPECT_THAT(reply.message, HasSubstr((folder() / (mapper + suffix)).string()));
    }
  EXPECT_GT(load_ply(folder() / "icp_map.ply").size(), 5000U);
  EXPECT_EQ(load_ply(folder() / "icp_map.ply").size(), load_pcd(folder() / "icp_map.pcd").size());
}

TEST_F(MapServer, OnlyTheFormatsAskedForAreWritten) {
  landmarks(1, 1, 0, {10});
  EXPECT_EQ(request(map_request_t::EXPORT, folder().string(), "pcd").status, 0);
  EXPECT_TRUE(exists("fastslam_map.pcd"));
  EXPECT_FALSE(exists("fastslam_map.ply"));
  EXPECT_FALSE(exists("fastslam_top.png"));
}

TEST_F(MapServer, RequestsThatCannotBeFulfilledSayWhy) {
  landmarks(1, 1, 0, {10});
  const map_reply_t format = request(map_request_t::EXPORT, folder().string(), "ply,stl");
  EXPECT_EQ(format.status, 1);
  EXPECT_THAT(format.message, AllOf(HasSubstr("'stl'"), HasSubstr("ply, pcd, png")));
  const auto file = scratch_.write("a-file", "x");
  const map_reply_t place = request(map_request_t::EXPORT, (file / "maps").string());
  EXPECT_EQ(place.status, 1);
  EXPECT_THAT(place.message, HasSubstr("a-file"));
  const map_reply_t kind = request(99);
  EXPECT_EQ(kind.status, 1);
  EXPECT_THAT(kind.message, HasSubstr("99"));
  EXPECT_EQ(request(map_request_t::INFO).status, 0);  // and it goes on
}

TEST_F(MapServer, InfoTellsWhatIsThere) {
  landmarks(1, 1, 0, {10, 11});
  keyframe(2, 0, 50);
  const auto text = [](const map_reply_t& reply) {
    return std::string(reply.data.begin(), reply.data.end());
  };
  EXPECT_THAT(text(request(map_request_t::INFO)),
              AllOf(HasSubstr("\"landmarks\": 2"), HasSubstr("\"keyframes\": 1")));
}

TEST_F(MapServer, MissedLandmarkChangeIsAskedForAgainAndRepaired) {
  landmarks(1, 1, 0, {10});
  pose("FASTSLAM_POSE", 1, 1, 10.0);
  landmarks(1, 3, 2, {12});  // the change from 1 to 2 is missing
  pose("FASTSLAM_POSE", 1, 3, 10.1);
  EXPECT_EQ(resends("fastslam"), 0U) << "it may still be under way";
  pose("FASTSLAM_POSE", 1, 3, 11.2);
  EXPECT_EQ(resends("fastslam"), 1U);
  pose("FASTSLAM_POSE", 1, 3, 11.3);
  EXPECT_EQ(resends("fastslam"), 1U) << "not with every message";
  landmarks(1, 4, 0, {10, 11, 12, 13});
  EXPECT_EQ(value_of(node_, "landmarks"), 4);
  landmarks(1, 5, 4, {14});
  EXPECT_EQ(value_of(node_, "landmarks"), 5);
  pose("FASTSLAM_POSE", 1, 5, 20.0);
  EXPECT_EQ(value_of(node_, "resends_asked"), 1);
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

TEST_F(MapServer, ServerThatStartsLateAsksForTheWholeMap) {
  pose("ICP_POSE", 2, 7, 100.0);
  pose("ICP_POSE", 2, 7, 101.5);
  EXPECT_EQ(resends("icp"), 1U);
}

TEST_F(MapServer, KeyframesThatTheMapperGaveUpAreForgotten) {
  for (int id = 0; id < 4; ++id) keyframe(2, id, 10);
  graph(2, {0, 1, 2, 3});
  EXPECT_EQ(value_of(node_, "keyframes"), 4);
  graph(2, {0});  // it began anew
  keyframe(2, 0, 20);
  EXPECT_EQ(value_of(node_, "keyframes"), 1);
  EXPECT_EQ(value_of(node_, "map_points"), 20);
}

TEST_F(MapServer, NewSenderBeginsANewSessionBesideTheOld) {
  landmarks(1, 1, 0, {10, 11});
  keyframe(2, 0, 30);
  landmarks(3, 1, 0, {20});
  keyframe(4, 0, 40);
  EXPECT_EQ(value_of(node_, "sessions"), 2);
  EXPECT_EQ(value_of(node_, "landmarks"), 1);
  EXPECT_EQ(value_of(node_, "map_points"), 40);
  EXPECT_EQ(request(map_request_t::EXPORT, folder().string(), "ply").status, 0);
  EXPECT_EQ(load_ply(folder() / "fastslam-session1_map.ply").size(), 2U);
  EXPECT_EQ(load_ply(folder() / "fastslam_map.ply").size(), 1U);
  EXPECT_EQ(load_ply(folder() / "icp-session1_map.ply").size(), 30U);
  EXPECT_EQ(load_ply(folder() / "icp_map.ply").size(), 40U);
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

TEST_F(MapServer, SavesWhatChangedAtItsEnd) {
  bus_.finish();
  EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "own"));
  landmarks(1, 1, 0, {10});
  bus_.finish();
  EXPECT_TRUE(std::filesystem::exists(scratch_.path() / "own" / "fastslam_map.ply"));
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
