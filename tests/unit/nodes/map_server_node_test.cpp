#include "procs/map-server/map_server_node.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <numeric>

#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/status_t.hpp>
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
                 const std::vector<std::int64_t>& ids, const std::vector<std::int64_t>& removed = {},
                 const std::string& frame = "map") {
    std::vector<Landmark> upserted;
    upserted.reserve(ids.size());
    for (const std::int64_t id : ids) upserted.push_back(testing::some_landmark(random_, id));
    for (landmarks_t& tile : make_landmark_tiles(1, revision, base, upserted, removed)) {
      tile.seq = seq_++;
      tile.sender = sender;
      tile.frame = frame;
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
  static graph_t graph_message(std::int64_t sender, const std::vector<std::int32_t>& ids,
                               std::int64_t keyframes) {
    graph_t m{};
    m.utime = 1;
    m.frame = "map";
    m.map_revision = keyframes;
    m.sender = sender;
    for (const std::int32_t id : ids) {
      graph_node_t node;
      node.keyframe = id;
      node.keyframe_utime = 1;
      node.T_map_camera = to_message(Eigen::Isometry3d::Identity());
      m.nodes.push_back(node);
    }
    m.n_nodes = static_cast<int32_t>(ids.size());
    return m;
  }
  void graph(std::int64_t sender, const std::vector<std::int32_t>& ids, std::int64_t keyframes = 1) {
    graph_t m = graph_message(sender, ids, keyframes);
    m.seq = seq_++;
    bus_.deliver("ICP_GRAPH", m);
  }
  /// A mapper's pose at `seconds`, measured against this revision of its map.
  void pose(const std::string& channel, std::int64_t sender, std::int64_t revision, double seconds,
            const std::string& frame = "map") {
    pose_estimate_t m = make_pose_estimate(static_cast<Utime>(1e6 * seconds), Eigen::Isometry3d::Identity(),
                                           Matrix6d::Identity());
    m.seq = seq_++;
    m.sender = sender;
    m.map_revision = revision;
    m.frame = frame;
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
  std::filesystem::path own() const { return scratch_.path() / "own"; }
  std::filesystem::path folder() const { return own() / "maps"; }

  Random random_{1};
  testing::ScratchFolder scratch_;
  testing::TestBus bus_;
  MapServerNode& node_ = bus_.add<MapServerNode>(
      ConfigNode::parse("{folder: " + own().string() + ", store: '', export_folders: 3}"));
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
  const map_reply_t reply = request(map_request_t::EXPORT, "maps");
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
  EXPECT_EQ(request(map_request_t::EXPORT, "maps", "pcd").status, 0);
  EXPECT_TRUE(exists("fastslam_map.pcd"));
  EXPECT_FALSE(exists("fastslam_map.ply"));
  EXPECT_FALSE(exists("fastslam_top.png"));
}

TEST_F(MapServer, RequestsThatCannotBeFulfilledSayWhy) {
  landmarks(1, 1, 0, {10});
  const map_reply_t format = request(map_request_t::EXPORT, "maps", "ply,stl");
  EXPECT_EQ(format.status, 1);
  EXPECT_THAT(format.message, AllOf(HasSubstr("'stl'"), HasSubstr("ply, pcd, png")));
  std::filesystem::create_directories(own());
  scratch_.write("own/a-file", "x");
  const map_reply_t place = request(map_request_t::EXPORT, "a-file");
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

TEST_F(MapServer, TwoMappersAtOnceDoNotMultiplySessions) {
  for (int i = 0; i < 10; ++i) {
    landmarks(1, i + 1, i, {100 + i});
    landmarks(3, i + 1, i, {200 + i});
  }
  EXPECT_EQ(value_of(node_, "sessions"), 2);
  EXPECT_EQ(value_of(node_, "landmarks"), 10);
  EXPECT_EQ(resends("fastslam"), 0U);
}

/// All files and folders below a folder.
std::vector<std::string> everything_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    names.push_back(entry.path().lexically_relative(folder).string());
  std::sort(names.begin(), names.end());
  return names;
}

TEST_F(MapServer, RequestsReachNothingOutsideTheRunsFolder) {
  landmarks(1, 1, 0, {10});
  std::filesystem::create_directories(own());
  std::filesystem::create_directories(scratch_.path() / "other");
  std::filesystem::create_directory_symlink(scratch_.path() / "other", own() / "link");
  const auto before = everything_in(scratch_.path());
  const std::string absolute = (scratch_.path() / "other").string();
  for (const std::string& name :
       {absolute, std::string("../other"), std::string("../.."), std::string("a/../../other"),
        std::string("link"), std::string("link/deeper"), std::string(".hidden"), std::string("a//b"),
        std::string("a/"), std::string("a b"), std::string("a\nb"), std::string("\xC3\xA4"),
        std::string(101, 'a')}) {
    const map_reply_t reply = request(map_request_t::EXPORT, name);
    EXPECT_EQ(reply.status, 1) << name;
    EXPECT_THAT(reply.message, ::testing::AnyOf(HasSubstr("letters, digits, dots, dashes and underscores"),
                                                HasSubstr("symbolic links are not followed")));
    EXPECT_EQ(reply.message.find('\n'), std::string::npos) << "a name must not forge lines of the log";
  }
  EXPECT_EQ(everything_in(scratch_.path()), before);
  EXPECT_EQ(value_of(node_, "requests_refused"), 13);
  EXPECT_EQ(request(map_request_t::EXPORT, "tour-1/second_half", "ply").status, 0);
  EXPECT_TRUE(std::filesystem::exists(own() / "tour-1/second_half/fastslam_map.ply"));
}

TEST_F(MapServer, FilesThatAreLinksAreNotFollowed) {
  landmarks(1, 1, 0, {10});
  std::filesystem::create_directories(folder());
  const auto victim = scratch_.write("victim", "untouched");
  std::filesystem::create_symlink(victim, folder() / "fastslam_map.ply");
  const map_reply_t reply = request(map_request_t::EXPORT, "maps", "ply");
  EXPECT_EQ(reply.status, 1);
  EXPECT_THAT(reply.message, HasSubstr("symbolic link"));
  EXPECT_EQ(scratch_.read("victim"), "untouched");
}

TEST_F(MapServer, RequestsMakeNoMoreFoldersThanTheyMay) {
  landmarks(1, 1, 0, {10});
  for (const std::string name : {"a", "b", "c", "a"})
    EXPECT_EQ(request(map_request_t::EXPORT, name, "ply").status, 0) << name;
  const map_reply_t reply = request(map_request_t::EXPORT, "d", "ply");
  EXPECT_EQ(reply.status, 1);
  EXPECT_THAT(reply.message, HasSubstr("export_folders"));
  EXPECT_FALSE(std::filesystem::exists(own() / "d"));
}

TEST_F(MapServer, SavesWhatChangedAtItsEnd) {
  bus_.finish();
  EXPECT_FALSE(std::filesystem::exists(own()));
  landmarks(1, 1, 0, {10});
  bus_.finish();
  EXPECT_TRUE(std::filesystem::exists(own() / "fastslam_map.ply"));
}

TEST_F(MapServer, CommandSavesWhileMappingGoesOn) {
  landmarks(1, 1, 0, {10});
  bus_.command("save");
  EXPECT_TRUE(testing::wait_for([&] { return node_.work(), value_of(node_, "saved") == 1; }));
  EXPECT_EQ(load_ply(own() / "fastslam_map.ply").size(), 1U);
}

TEST_F(MapServer, MapsThatCannotBeSavedAtTheEndAreAFailureThatNamesTheCause) {
  landmarks(1, 1, 0, {10});
  scratch_.write("own", "a file where the folder should be");
  bus_.finish();
  const NodeReport report = node_.report();
  EXPECT_EQ(report.state, status_t::FAILED);
  EXPECT_THAT(report.detail, AllOf(HasSubstr("maps are not saved"), HasSubstr(own().string())));
  std::filesystem::remove(own());
  bus_.finish();
  EXPECT_EQ(node_.report().state, status_t::RUNNING) << "there is room again";
}

class MapServerSnapshots : public MapServer {
 protected:
  MapServerNode& often_ = bus_.add<MapServerNode>(ConfigNode::parse(
      "{folder: " + (scratch_.path() / "often").string() + ", store: '', snapshot_period: 0.01}"));
  bool wait_for_saved(double count) {
    return testing::wait_for([&] { return often_.work(), value_of(often_, "saved") == count; });
  }
};

TEST_F(MapServerSnapshots, WhatIsMappedIsOnDiskWithoutAnEnd) {
  landmarks(1, 1, 0, {10, 11});
  keyframe(2, 0, 100);
  ASSERT_TRUE(wait_for_saved(1));
  EXPECT_EQ(load_ply(scratch_.path() / "often/fastslam_map.ply").size(), 2U);
  EXPECT_GT(load_ply(scratch_.path() / "often/icp_map.ply").size(), 50U);
  landmarks(1, 2, 1, {12});
  ASSERT_TRUE(wait_for_saved(2));
  EXPECT_EQ(load_ply(scratch_.path() / "often/fastslam_map.ply").size(), 3U);
}

TEST_F(MapServerSnapshots, NothingIsWrittenWhenNothingChanged) {
  landmarks(1, 1, 0, {10});
  ASSERT_TRUE(wait_for_saved(1));
  std::filesystem::remove_all(scratch_.path() / "often");
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(50);  // five periods
  while (std::chrono::steady_clock::now() < until) often_.work();
  EXPECT_EQ(value_of(often_, "saved"), 1);
  EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "often"));
}

// The kitchen's map has 31 keyframes with 380,000 points and 2,300 landmarks.
TEST_F(MapServerSnapshots, MessagesDoNotWaitForThem) {
  for (std::int32_t id = 0; id < 31; ++id) keyframe(2, id, 12'000);
  std::vector<std::int64_t> ids(2'300);
  std::iota(ids.begin(), ids.end(), 1);
  landmarks(1, 1, 0, ids);
  double shortest = INFINITY;  // of several: the machine may have other things to do
  for (int snapshot = 1; snapshot <= 4; ++snapshot) {
    double longest = 0;
    landmarks(1, snapshot + 1, snapshot, {5'000 + snapshot});
    bus_.command("save");  // by itself it pauses after a saving that took long
    ASSERT_TRUE(testing::wait_for([&] {
      const auto begin = std::chrono::steady_clock::now();
      often_.work();
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
      longest = std::max(longest, took.count());
      return value_of(often_, "saved") >= snapshot;
    }));
    shortest = std::min(shortest, longest);
  }
  RecordProperty("stall_us", static_cast<int>(1e6 * shortest));
  EXPECT_LT(shortest, 0.05);
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
