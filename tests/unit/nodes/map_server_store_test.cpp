// The map server's file: what it hears is in it, and the next one goes on with it.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/map_store/file/check_map_file.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/status_t.hpp>
#include "procs/map-server/map_server_node.hpp"
#include "tests/support/test_bus.hpp"
#include "tests/unit/messages/samples.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::value_of;

constexpr Utime second = 1'000'000;

/// One life of a map server.
class Server {
 public:
  /// `fastslam` and the number after it are the mappers' senders.
  explicit Server(const std::filesystem::path& folder, std::int64_t fastslam = 1)
      : fastslam_(fastslam),
        icp_(fastslam + 1),
        node_(bus_.add<MapServerNode>(ConfigNode::parse("{folder: " + folder.string() + "}"))) {}

  template <class M>
  void send(const std::string& channel, M message, std::int64_t sender) {
    message.seq = seq_++;
    message.sender = sender;
    bus_.deliver(channel, message);
  }
  void landmarks(std::int64_t revision, std::int64_t base, const std::vector<std::int64_t>& ids,
                 const std::vector<std::int64_t>& removed = {}) {
    std::vector<Landmark> upserted;
    for (const std::int64_t id : ids) upserted.push_back(testing::some_landmark(random_, id));
    for (const landmarks_t& tile : make_landmark_tiles(1, revision, base, upserted, removed))
      send("FASTSLAM_LANDMARKS", tile, fastslam_);
  }
  DenseKeyframe keyframe(std::int32_t id, Utime utime = 0, std::size_t points = 30) {
    DenseKeyframe k = testing::some_keyframe(random_, points);
    k.id = id;
    k.utime = utime;
    for (const keyframe_t& tile : make_keyframe_tiles(k, Eigen::Isometry3d::Identity(), id + 1))
      send("ICP_KEYFRAME", tile, icp_);
    return k;
  }
  /// After a while without anybody, until it is believed.
  void speak(const std::string& channel, std::int64_t sender, const std::string& frame) {
    time_ += 5 * second;
    for (int i = 0; i < 10; ++i) pose(channel, sender, time_ += second / 10, frame);
  }
  /// A mapper of that sender begins a map.
  void landmarks_of(std::int64_t sender, const std::string& frame, const std::vector<std::int64_t>& ids) {
    speak("FASTSLAM_POSE", sender, frame);
    std::vector<Landmark> upserted;
    for (const std::int64_t id : ids) upserted.push_back(testing::some_landmark(random_, id));
    for (landmarks_t& tile : make_landmark_tiles(1, 1, 0, upserted, {})) {
      tile.frame = frame;
      send("FASTSLAM_LANDMARKS", tile, sender);
    }
  }
  void keyframe_of(std::int64_t sender, const std::string& frame, std::size_t points, std::int32_t id = 0) {
    speak("ICP_POSE", sender, frame);
    DenseKeyframe k = testing::some_keyframe(random_, points);
    k.id = id;
    k.utime = time_;
    for (keyframe_t& tile : make_keyframe_tiles(k, Eigen::Isometry3d::Identity(), id + 1)) {
      tile.frame = frame;
      send("ICP_KEYFRAME", tile, sender);
    }
  }
  /// Nodes at x = 1; seq 0 and `whole`, or a change that builds on the message before.
  void graph(std::int64_t seq, bool whole, const std::vector<std::int32_t>& ids,
             const std::vector<std::int32_t>& gone = {}, const std::vector<std::int32_t>& chain = {}) {
    graph_t m{};
    m.utime = 1;
    m.frame = "map";
    m.change = whole ? 0 : 1;
    m.gone = gone;
    m.n_gone = static_cast<std::int32_t>(gone.size());
    for (const std::int32_t id : ids) {
      graph_node_t node;
      node.keyframe = id;
      node.keyframe_utime = 5;
      node.T_map_camera = to_message(Eigen::Isometry3d(Eigen::Translation3d(1, 0, 0)));
      m.nodes.push_back(node);
    }
    m.n_nodes = static_cast<std::int32_t>(ids.size());
    for (std::size_t i = 1; i < chain.size(); ++i) {
      graph_edge_t edge{};
      edge.from_node = chain[i - 1];
      edge.to_node = chain[i];
      edge.kind = graph_edge_t::LOOP;
      edge.T_from_to = to_message(Eigen::Isometry3d::Identity());
      m.edges.push_back(edge);
    }
    m.n_edges = static_cast<std::int32_t>(m.edges.size());
    m.seq = seq;
    m.sender = icp_;
    bus_.deliver("ICP_GRAPH", m);
  }
  void features(Utime utime, int count) {
    FeatureFrame frame = testing::some_features(random_, static_cast<std::size_t>(count));
    frame.utime = utime;
    send("FEATURES", to_message(frame), 3);
  }
  void pose(const std::string& channel, std::int64_t sender, Utime utime, const std::string& frame = "map") {
    pose_estimate_t message =
        make_pose_estimate(utime, Eigen::Isometry3d::Identity(), 4 * Matrix6d::Identity());
    message.frame = frame;
    send(channel, message, sender);
  }
  map_reply_t export_to(const std::string& name) {
    map_request_t m{};
    m.kind = map_request_t::EXPORT;
    m.argument = name;
    m.format = "ply";
    send("MAP_REQUEST", m, 9);
    return bus_.on<map_reply_t>("MAP_REPLY").back();
  }
  void finish() { bus_.finish(); }
  MapServerNode& node() { return node_; }
  testing::TestBus& bus() { return bus_; }

 private:
  Random random_{1};
  std::int64_t fastslam_, icp_;
  testing::TestBus bus_;
  MapServerNode& node_;
  std::int64_t seq_ = 0;
  Utime time_ = 0;
};

class MapServerStore : public ::testing::Test {
 protected:
  std::filesystem::path run() const { return scratch_.path() / "run"; }
  std::filesystem::path file() const { return run() / "map.lcmslam"; }
  std::int64_t session(const std::string& mapper) {
    for (const StoredSession& s : MapFile(file()).sessions())
      if (s.mapper == mapper) return s.id;
    return 0;
  }
  std::vector<std::string> faults() { return check_map_file(file()).faults; }

  testing::ScratchFolder scratch_;
};

TEST_F(MapServerStore, WhatIsHeardIsInTheFileWithoutAnEnd) {
  Server server(run());
  EXPECT_FALSE(std::filesystem::exists(run())) << "nothing was mapped";
  server.landmarks(1, 0, {10, 11, 12});
  server.landmarks(2, 1, {13}, {11});
  server.keyframe(0, second, 6000);  // more than one tile
  EXPECT_TRUE(testing::wait_for([&] {
    return std::filesystem::exists(file()) && !MapFile(file()).sessions().empty() && session("icp") != 0 &&
           MapFile(file()).counts(session("icp")).clouds == 1;
  }));
  EXPECT_EQ(MapFile(file()).landmarks(session("fastslam")).size(), 3U);
  EXPECT_EQ(MapFile(file()).counts(session("icp")).points, 6000);
  EXPECT_THAT(MapFile(file()).runs().at(0).configuration, HasSubstr("resolution: 0.02"));
  EXPECT_GE(value_of(server.node(), "store_commits"), 1);
}

TEST_F(MapServerStore, TheFileFollowsTheGraph) {
  Server server(run());
  for (int id = 0; id < 5; ++id) server.keyframe(id);
  server.graph(0, true, {0, 1, 2, 3, 4, 5}, {}, {0, 1, 2, 3, 4});  // 5 has no cloud
  server.graph(1, false, {1}, {2});
  server.graph(2, true, {0, 1, 3, 4}, {}, {0, 1});
  server.finish();
  MapFile read(file());
  const std::int64_t icp = session("icp");
  EXPECT_EQ(read.keyframes(icp).size(), 4U);
  EXPECT_EQ(read.dense_map(icp).keyframes().size(), 4U);
  for (const StoredKeyframe& keyframe : read.keyframes(icp))
    EXPECT_EQ(keyframe.T_map_camera.translation(), Eigen::Vector3d(1, 0, 0)) << keyframe.id;
  ASSERT_EQ(read.edges(icp).size(), 1U);
  EXPECT_EQ(read.edges(icp)[0].kind, graph_edge_t::LOOP);
  EXPECT_THAT(faults(), IsEmpty());
}

TEST_F(MapServerStore, ChangesOfTheGraphCutEdges) {
  Server server(run());
  for (int id = 0; id < 4; ++id) server.keyframe(id);
  server.graph(0, true, {0, 1, 2, 3}, {}, {0, 1, 2, 3});
  server.graph(1, false, {}, {3});
  server.finish();
  EXPECT_EQ(MapFile(file()).edges(session("icp")).size(), 2U);
  EXPECT_EQ(check_map_file(file()).loose_edges, 0);
}

TEST_F(MapServerStore, KeyframesHaveTheFeaturesAndTheCovarianceOfTheirMoment) {
  Server server(run());
  server.features(10 * second, 4);
  server.features(10 * second + 33'000, 5);
  server.pose("ICP_POSE", 2, 10 * second + 30'000);
  server.keyframe(0, 10 * second + 30'000);
  server.keyframe(1, 20 * second);  // before its features
  server.keyframe(2, 21 * second);  // whose features never come
  server.features(19 * second + 990'000, 6);
  server.finish();
  MapFile read(file());
  const std::int64_t icp = session("icp");
  ASSERT_TRUE(read.features(icp, 0));
  EXPECT_EQ(read.features(icp, 0)->features.size(), 5U);
  ASSERT_TRUE(read.features(icp, 1));
  EXPECT_EQ(read.features(icp, 1)->features.size(), 6U);
  EXPECT_FALSE(read.features(icp, 2));
  ASSERT_TRUE(read.keyframes(icp)[0].covariance);
  EXPECT_TRUE(read.keyframes(icp)[0].covariance->isApprox(4 * Matrix6d::Identity()));
  EXPECT_FALSE(read.keyframes(icp)[1].covariance);
}

TEST_F(MapServerStore, PathsAndCalibrationsAreKept) {
  Server server(run());
  for (int i = 0; i < 4; ++i) {
    server.pose("FASTSLAM_POSE", 1, second + i * 100'000);
    camera_calibration_t calibration;
    {
      Random random(1);
      calibration = to_message(testing::some_calibration(random));
    }
    calibration.utime = second + i;
    server.send("CAMERA_CALIBRATION", calibration, 4);
  }
  server.finish();
  EXPECT_EQ(MapFile(file()).trajectory(session("fastslam")).size(), 4U);
  ASSERT_EQ(MapFile(file()).calibrations().size(), 1U);
  const auto stored = MapFile(file()).calibrations()[0];
  EXPECT_NO_THROW(decode_message<camera_calibration_t>(stored.bytes.data(), stored.bytes.size()));
}

TEST_F(MapServerStore, TheNextServerGoesOnBesideTheOldSessions) {
  {
    Server server(run());
    server.landmarks(1, 0, {10, 11});
    server.keyframe(0, 0, 20);
    server.finish();
  }
  Server server(run(), 11);
  EXPECT_EQ(value_of(server.node(), "kept_sessions"), 2);
  EXPECT_EQ(value_of(server.node(), "landmarks"), 0) << "it does not know where it is in the old map";
  server.landmarks(1, 0, {10});
  const map_reply_t reply = server.export_to("both");
  EXPECT_EQ(reply.status, 0) << reply.message;
  EXPECT_EQ(load_ply(run() / "both/fastslam_map.ply").size(), 1U);
  EXPECT_EQ(load_ply(run() / "both/fastslam-session1_map.ply").size(), 2U);
  EXPECT_EQ(load_ply(run() / "both/icp-session1_map.ply").size(), 20U);
  server.finish();
  EXPECT_EQ(MapFile(file()).sessions().size(), 3U);
  EXPECT_EQ(MapFile(file()).landmarks(1).size(), 2U);
  EXPECT_THAT(faults(), IsEmpty());
}

// The server alone died; the mappers' maps are the same as before.
TEST_F(MapServerStore, SessionsOfMappersThatLiveOnGoOn) {
  {
    Server server(run());
    server.landmarks(1, 0, {10, 11});
    for (int id = 0; id < 4; ++id) server.keyframe(id);
    server.finish();
  }
  Server server(run());
  server.landmarks(2, 0, {10, 12});
  server.keyframe(4);
  server.graph(7, true, {0, 3, 4});  // 1 and 2 went meanwhile
  server.finish();
  EXPECT_EQ(value_of(server.node(), "kept_sessions"), 0);
  MapFile read(file());
  EXPECT_EQ(read.sessions().size(), 2U);
  EXPECT_EQ(read.landmarks(session("fastslam")).size(), 2U);
  const DenseMap dense = read.dense_map(session("icp"));
  EXPECT_EQ(dense.keyframes().size(), 3U) << "with the clouds of the earlier life";
  EXPECT_EQ(dense.keyframes().count(1) + dense.keyframes().count(2), 0U);
  EXPECT_THAT(faults(), IsEmpty());
}

// A mapper that is restarted again and again would fill the server's memory, and at last its table.
TEST_F(MapServerStore, MapsThatTheirMapperHasLeftAreKeptInTheFileAlone) {
  constexpr int lives = 40;  // more than max_sessions
  Server server(run());
  for (int life = 0; life < lives; ++life) {
    server.landmarks_of(100 + life, "map", {10, 11, 12 + life});
    server.keyframe_of(200 + life, "map", 20);
    ASSERT_TRUE(testing::wait_for([&] {
      server.bus().work();
      return value_of(server.node(), "sessions") == 1 && value_of(server.node(), "kept_sessions") == 2 * life;
    })) << life;
  }
  EXPECT_EQ(value_of(server.node(), "sessions_refused"), 0);
  EXPECT_EQ(value_of(server.node(), "landmarks"), 3);
  const auto told = server.node().told_sessions();
  ASSERT_EQ(told.size(), 2U * lives);
  for (const std::size_t first : {0, 1}) {
    const bool dense = told[first].mapper == "icp";
    EXPECT_EQ(told[first].name, dense ? "icp-session1" : "fastslam-session1");
    EXPECT_TRUE(told[first].is_kept);
    EXPECT_EQ(told[first].keyframes, dense ? 1U : 0U);
    EXPECT_EQ(told[first].landmarks, dense ? 0U : 3U);
  }
  EXPECT_EQ(server.export_to("all").status, 0);
  server.finish();
  for (int life = 1; life < lives; ++life) {
    EXPECT_EQ(load_ply(run() / fmt::format("all/fastslam-session{}_map.ply", life)).size(), 3U) << life;
    EXPECT_EQ(load_ply(run() / fmt::format("all/icp-session{}_map.ply", life)).size(), 20U) << life;
  }
  EXPECT_EQ(MapFile(file()).sessions().size(), 2U * lives);
  EXPECT_THAT(faults(), IsEmpty());
}

// It was stopped for a while, say, and another was started meanwhile.
TEST_F(MapServerStore, AMapperThatComesBackGoesOnWithItsMap) {
  Server server(run());
  for (int id = 0; id < 4; ++id) server.keyframe_of(200, "map", 20, id);
  server.keyframe_of(200, "map-2", 20);
  EXPECT_TRUE(testing::wait_for([&] {
    server.bus().work();
    return value_of(server.node(), "kept_sessions") == 1;
  }));
  server.keyframe_of(200, "map", 20, 4);
  EXPECT_TRUE(testing::wait_for([&] {
    server.bus().work();
    return value_of(server.node(), "sessions") == 1;
  }));
  server.finish();
  MapFile read(file());
  ASSERT_EQ(read.sessions().size(), 2U);
  EXPECT_EQ(read.dense_map(1).keyframes().size(), 5U);
  EXPECT_EQ(read.dense_map(2).keyframes().size(), 1U);
  EXPECT_EQ(value_of(server.node(), "kept_sessions"), 1);
}

// Else it would be lost when memory is given back.
TEST_F(MapServerStore, WhatIsNotInTheFileStaysInMemory) {
  std::filesystem::create_directory(run());
  scratch_.write("run/map.lcmslam",
                 "a letter that is no map, but has the name of one: long enough for SQLite");
  Server server(run());
  for (int life = 0; life < 3; ++life) {
    server.landmarks_of(100 + life, "map", {10, 11});
    server.bus().work();
  }
  EXPECT_EQ(value_of(server.node(), "sessions"), 3);
  server.export_to("all");
  EXPECT_EQ(load_ply(run() / "all/fastslam-session1_map.ply").size(), 2U);
  server.finish();
}

// What the new server has not in memory is in the file alone.
TEST_F(MapServerStore, AGraphThatTakesTheMostAwayLeavesTheFilesMapBeside) {
  {
    Server server(run());
    for (int id = 0; id < 5; ++id) server.keyframe(id, 0, 20);
    server.finish();
  }
  Server server(run());
  server.keyframe(5);
  server.graph(7, true, {0, 5});
  server.finish();
  MapFile read(file());
  ASSERT_EQ(read.sessions().size(), 2U);
  for (int id = 0; id < 5; ++id) EXPECT_EQ(read.dense_map(1).keyframes().count(id), 1U) << id;
  EXPECT_EQ(read.dense_map(2).keyframes().size(), 1U);
  EXPECT_EQ(value_of(server.node(), "kept_sessions"), 1);
  EXPECT_GE(load_ply(run() / "icp-session1_map.ply").size(), 100U);
  EXPECT_THAT(faults(), IsEmpty());
}

TEST_F(MapServerStore, WhatIsTakenAwayIsKeptBesideInTheFile) {
  Server server(run());
  server.landmarks(1, 0, {10, 11, 12, 13, 14});
  server.landmarks(2, 1, {}, {10, 11, 12, 13});
  for (int id = 0; id < 5; ++id) server.keyframe(id);
  server.graph(0, true, {});
  server.finish();
  std::map<std::string, std::int64_t> things;
  MapFile read(file());
  for (const StoredSession& s : read.sessions())
    things[s.mapper + " " + s.frame] = read.counts(s.id).landmarks + read.counts(s.id).clouds;
  EXPECT_EQ(things,
            (std::map<std::string, std::int64_t>{
                {"fastslam map", 1}, {"fastslam map-kept-1", 5}, {"icp map", 0}, {"icp map-kept-1", 5}}));
}

TEST_F(MapServerStore, AFileThatCannotBeWrittenIsSaidAndMappingGoesOn) {
  std::filesystem::create_directory(run());
  scratch_.write("run/map.lcmslam",
                 "a letter that is no map, but has the name of one: long enough for SQLite");
  const std::string letter = scratch_.read("run/map.lcmslam");
  Server server(run());
  server.landmarks(1, 0, {10});
  const NodeReport report = server.node().report();
  EXPECT_THAT(report.detail, AllOf(HasSubstr("the map's file is not written"), HasSubstr(file().string())));
  EXPECT_EQ(report.state, status_t::RUNNING);
  EXPECT_EQ(value_of(server.node(), "landmarks"), 1);
  EXPECT_EQ(server.export_to("maps").status, 0);
  server.finish();
  EXPECT_EQ(server.node().report().state, status_t::FAILED) << "the exit code says it";
  EXPECT_TRUE(std::filesystem::exists(run() / "fastslam_map.ply"));
  EXPECT_EQ(scratch_.read("run/map.lcmslam"), letter);
}

TEST_F(MapServerStore, NamesThatLeadElsewhereAreRefused) {
  testing::TestBus bus;
  for (const std::string name : {"../map", "/tmp/map", ".map"})
    EXPECT_THROW(bus.add<MapServerNode>(ConfigNode::parse("{folder: x, store: " + name + "}")),
                 std::runtime_error)
        << name;
}

}  // namespace
}  // namespace lcmslam
