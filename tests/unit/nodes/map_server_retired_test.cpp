// Maps that their mapper has left: they are kept in the file alone, and lost nowhere.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <lcmslam/map_store/map_export.hpp>
#include "tests/unit/nodes/map_server_store_fixture.hpp"

namespace lcmslam {
namespace {

using ::testing::IsEmpty;
using testing::StoringServer;
using testing::value_of;

class MapServerRetired : public testing::MapServerStore {};

// A mapper that is restarted again and again would fill the server's memory, and at last its table.
TEST_F(MapServerRetired, MapsThatTheirMapperHasLeftAreKeptInTheFileAlone) {
  constexpr int lives = 40;  // more than max_sessions
  StoringServer server(run());
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
TEST_F(MapServerRetired, AMapperThatComesBackGoesOnWithItsMap) {
  StoringServer server(run());
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
TEST_F(MapServerRetired, WhatIsNotInTheFileStaysInMemory) {
  std::filesystem::create_directory(run());
  scratch_.write("run/map.lcmslam",
                 "a letter that is no map, but has the name of one: long enough for SQLite");
  StoringServer server(run());
  for (int life = 0; life < 3; ++life) {
    server.landmarks_of(100 + life, "map", {10, 11});
    server.bus().work();
  }
  EXPECT_EQ(value_of(server.node(), "sessions"), 3);
  server.export_to("all");
  EXPECT_EQ(load_ply(run() / "all/fastslam-session1_map.ply").size(), 2U);
  server.finish();
}

}  // namespace
}  // namespace lcmslam
