// The map server's file: what it hears is in it, and the next one goes on with it.

#include <gmock/gmock.h>
#include <numeric>

#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/status_t.hpp>
#include "tests/unit/nodes/map_server_store_fixture.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::MapServerStore;
using testing::StoringServer;
using testing::value_of;

constexpr Utime second = 1'000'000;

TEST_F(MapServerStore, WhatIsHeardIsInTheFileWithoutAnEnd) {
  StoringServer server(run());
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
  StoringServer server(run());
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

TEST_F(MapServerStore, AnOldGraphTakesNoLaterKeyframesOutOfTheFile) {
  {
    StoringServer server(run());
    for (int id = 0; id < 3; ++id) server.keyframe(id, (id + 1) * second);
    server.finish();
  }
  StoringServer restarted(run());
  restarted.graph(0, true, {0, 1});
  restarted.finish();
  EXPECT_EQ(MapFile(file()).keyframes(session("icp")).size(), 3U);
}

TEST_F(MapServerStore, WhenAnotherFileIsWrittenOverItAllThatIsInMemoryGoesBeside) {
  const std::filesystem::path another = scratch_.path() / "another";
  {
    StoringServer other(another);
    other.landmarks(1, 0, {1, 2});
    other.finish();
  }
  StoringServer server(run(), 5);
  server.landmarks(1, 0, {10, 11, 12});
  for (int id = 0; id < 3; ++id) server.keyframe(id, second);
  server.graph(0, true, {0, 1, 2}, {}, {0, 1, 2});
  EXPECT_TRUE(testing::wait_for(
      [&] { return testing::value_of(server.node(), "store_commits") > 0 && session("icp") != 0; }));
  std::ofstream(file(), std::ios::binary) << std::ifstream(another / "map.lcmslam", std::ios::binary).rdbuf();
  server.keyframe(3, second);
  EXPECT_TRUE(testing::wait_for([&] {
    server.bus().work();
    return server.node().report().detail.find("map-2.lcmslam") != std::string::npos;
  }));
  server.landmarks(2, 1, {13});
  server.keyframe(4, second);
  server.finish();
  EXPECT_EQ(MapFile(file()).landmarks(1).size(), 2U) << "the other one";
  EXPECT_EQ(MapFile(file()).sessions().size(), 1U);
  EXPECT_THAT(faults(), IsEmpty());
  const std::filesystem::path beside = run() / "map-2.lcmslam";
  EXPECT_THAT(check_map_file(beside).faults, IsEmpty());
  MapFile read(beside);
  ASSERT_EQ(read.sessions().size(), 2U);
  for (const StoredSession& stored : read.sessions()) {
    const bool dense = stored.mapper == "icp";
    EXPECT_EQ(read.counts(stored.id).clouds, dense ? 5 : 0);
    EXPECT_EQ(read.counts(stored.id).edges, dense ? 2 : 0);
    EXPECT_EQ(read.landmarks(stored.id).size(), dense ? 0U : 4U);
  }
}

TEST_F(MapServerStore, ChangesOfTheGraphCutEdges) {
  StoringServer server(run());
  for (int id = 0; id < 4; ++id) server.keyframe(id);
  server.graph(0, true, {0, 1, 2, 3}, {}, {0, 1, 2, 3});
  server.graph(1, false, {}, {3});
  server.finish();
  EXPECT_EQ(MapFile(file()).edges(session("icp")).size(), 2U);
  EXPECT_EQ(check_map_file(file()).loose_edges, 0);
}

TEST_F(MapServerStore, KeyframesHaveTheFeaturesAndTheCovarianceOfTheirMoment) {
  StoringServer server(run());
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
  StoringServer server(run());
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
    StoringServer server(run());
    server.landmarks(1, 0, {10, 11});
    server.keyframe(0, 0, 20);
    server.finish();
  }
  StoringServer server(run(), 11);
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
    StoringServer server(run());
    server.landmarks(1, 0, {10, 11});
    for (int id = 0; id < 4; ++id) server.keyframe(id);
    server.finish();
  }
  StoringServer server(run());
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

/// How many of the session's keyframes have features.
int with_features(MapFile& file, std::int64_t session) {
  int count = 0;
  for (const StoredKeyframe& keyframe : file.keyframes(session))
    count += file.features(session, keyframe.id) ? 1 : 0;
  return count;
}

// What the new server has not in memory is in the file alone.
TEST_F(MapServerStore, AGraphThatTakesTheMostAwayLeavesTheFilesMapBeside) {
  {
    StoringServer server(run());
    for (int id = 0; id < 5; ++id) server.keyframe(id, 0, 20);
    server.finish();
  }
  StoringServer server(run());
  server.features(10 * second, 5);
  server.keyframe(5, 10 * second);
  server.graph(7, true, {0, 5});
  server.finish();
  MapFile read(file());
  ASSERT_EQ(read.sessions().size(), 2U);
  for (int id = 0; id < 5; ++id) EXPECT_EQ(read.dense_map(1).keyframes().count(id), 1U) << id;
  EXPECT_EQ(read.dense_map(2).keyframes().size(), 1U);
  EXPECT_EQ(with_features(read, 2), 1) << "it goes on with what was known of them";
  EXPECT_EQ(value_of(server.node(), "kept_sessions"), 1);
  EXPECT_GE(load_ply(run() / "icp-session1_map.ply").size(), 100U);
  EXPECT_THAT(faults(), IsEmpty());
}

// What is left beside is a map to be found in as any other: with the features of its keyframes.
TEST_F(MapServerStore, AMapThatIsLeftBesideKeepsItsFeatures) {
  StoringServer server(run());
  for (int id = 0; id < 4; ++id) {
    server.features((10 + id) * second, 5);
    server.keyframe(id, (10 + id) * second);
  }
  server.graph(0, true, {0, 1, 2, 3});
  server.graph(1, false, {}, {0, 1, 2});
  server.finish();
  MapFile read(file());
  ASSERT_EQ(read.sessions().size(), 2U);
  int whole = 0;
  for (const StoredSession& session : read.sessions())
    if (read.keyframes(session.id).size() == 4) whole += with_features(read, session.id);
  EXPECT_EQ(whole, 4);
  EXPECT_THAT(faults(), IsEmpty());
}

std::vector<std::int64_t> ids_to(std::int64_t end) {
  std::vector<std::int64_t> ids(static_cast<std::size_t>(end));
  std::iota(ids.begin(), ids.end(), 0);
  return ids;
}

// Of a map in three tiles one is lost, and changes follow that build on it.
TEST_F(MapServerStore, AMapThatComesInPartTakesNothingFromTheFile) {
  {
    StoringServer server(run());
    server.landmarks(1, 0, ids_to(1000));
    server.finish();
  }
  StoringServer server(run());
  std::vector<landmarks_t> tiles = server.tiles_of(2, 0, ids_to(1000));
  ASSERT_GT(tiles.size(), 1U);
  tiles.pop_back();
  for (const landmarks_t& tile : tiles) server.send("FASTSLAM_LANDMARKS", tile, 1);
  server.finish();
  EXPECT_EQ(MapFile(file()).landmarks(session("fastslam")).size(), 1000U);
}

TEST_F(MapServerStore, LateChangesTakeNothingFromTheFile) {
  {
    StoringServer server(run());
    server.landmarks(1, 0, ids_to(20));
    server.finish();
  }
  StoringServer server(run());
  server.landmarks(9, 8, {3});
  server.landmarks(7, 6, {4, 5});  // older: memory leaves it out
  server.finish();
  EXPECT_EQ(MapFile(file()).landmarks(session("fastslam")).size(), 20U);
}

TEST_F(MapServerStore, LandmarksThatAreTakenAwayAfterARestartStayBeside) {
  for (const bool whole : {true, false}) {
    std::filesystem::remove_all(run());
    {
      StoringServer server(run());
      server.landmarks(1, 0, ids_to(300));
      server.finish();
    }
    StoringServer server(run());
    whole ? server.landmarks(2, 0, {}) : server.landmarks(2, 1, {}, ids_to(300));
    server.landmarks(3, 2, {7});
    server.finish();
    MapFile read(file());
    ASSERT_EQ(read.sessions().size(), 2U) << whole;
    EXPECT_EQ(read.landmarks(1).size(), 300U) << whole;
    EXPECT_EQ(read.landmarks(2).size(), 1U) << whole;
    EXPECT_EQ(value_of(server.node(), "kept_sessions"), 1) << whole;
    ASSERT_FALSE(server.node().told_sessions().empty());
    EXPECT_EQ(server.node().told_sessions().front().landmarks, 300U) << "as it was told before";
    EXPECT_THAT(faults(), IsEmpty());
  }
}

// Each server counts the maps that it keeps beside from one on, and their mapper may outlive it.
TEST_F(MapServerStore, WhatTwoServersKeptBesideIsNotMixed) {
  {
    StoringServer server(run());
    server.landmarks(1, 0, {10, 11, 12, 13, 14});
    server.landmarks(2, 1, {}, {10, 11, 12, 13});
    server.finish();
  }
  StoringServer server(run());
  server.landmarks(3, 0, {20, 21, 22, 23, 24, 25, 26, 27, 28, 29});
  server.landmarks(4, 3, {}, {20, 21, 22, 23, 24, 25, 26, 27, 28});
  server.finish();
  std::multiset<std::int64_t> kept;
  MapFile read(file());
  for (const StoredSession& s : read.sessions())
    if (s.frame == "map-kept-1") kept.insert(read.counts(s.id).landmarks);
  EXPECT_THAT(kept, ::testing::ElementsAre(5, 10));
}

TEST_F(MapServerStore, WhatIsTakenAwayIsKeptBesideInTheFile) {
  StoringServer server(run());
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
  StoringServer server(run());
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

// Mapping goes on meanwhile, and nothing is written before it is known what the file has.
TEST_F(MapServerStore, AFileThatSomebodyHoldsIsReadOnceItIsFree) {
  {
    StoringServer server(run());
    server.landmarks(1, 0, {10, 11});
    server.finish();
  }
  auto other = std::make_unique<Database>(file(), Database::Access::write);
  other->execute("PRAGMA locking_mode = EXCLUSIVE; BEGIN EXCLUSIVE; COMMIT");
  StoringServer server(run(), 11);
  EXPECT_THAT(server.node().report().detail,
              AllOf(HasSubstr("the map's file is not written"), HasSubstr("locked")));
  server.landmarks(1, 0, {10, 11, 12});
  EXPECT_EQ(value_of(server.node(), "kept_sessions"), 0);
  other.reset();
  EXPECT_TRUE(testing::wait_for([&] {
    server.bus().work();
    return value_of(server.node(), "kept_sessions") == 1 && server.node().report().detail.empty();
  })) << server.node().report().detail;
  server.finish();
  EXPECT_NE(server.node().report().state, status_t::FAILED);
  EXPECT_TRUE(std::filesystem::exists(run() / "fastslam-session1_map.ply"));
  EXPECT_EQ(MapFile(file()).sessions().size(), 2U);
  EXPECT_EQ(MapFile(file()).landmarks(2).size(), 3U);
}

TEST_F(MapServerStore, DamageIsNotTakenForAFailureToWrite) {
  {
    StoringServer server(run());
    server.keyframe(0, 0, 20);
    server.keyframe_of(21, "map-2", 30);
    server.finish();
  }
  Database(file(), Database::Access::write)
      .execute("UPDATE keyframe SET pose = zeroblob(10) WHERE session = 1");
  StoringServer server(run(), 41);
  EXPECT_EQ(value_of(server.node(), "kept_sessions"), 2);
  EXPECT_THAT(server.node().report().detail,
              AllOf(HasSubstr("cannot be read"), ::testing::Not(HasSubstr("not written"))));
  server.export_to("both");
  EXPECT_EQ(load_ply(run() / "both/icp-session2_map.ply").size(), 30U);
  server.finish();
  EXPECT_NE(server.node().report().state, status_t::FAILED);
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
