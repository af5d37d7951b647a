// Sessions that begin anywhere find their place in the map of the file, and who is lost his, in the simulated
// kitchen, where all places are known.

#include "tests/unit/nodes/map_server_places_fixture.hpp"

namespace lcmslam {
namespace {

using nlohmann::json;
using testing::first_number;
using ::testing::HasSubstr;
using testing::Life;
using testing::MapServerPlaces;
using testing::seen_view;
using testing::SeenView;
using testing::views_of_room;

TEST_F(MapServerPlaces, ASessionThatBeginsElsewhereIsJoined) {
  map_once();
  Life server(scratch_.path(), "map", 13, "{background: false, rate: 0}");
  server.drive(first_number + 2, elsewhere());
  EXPECT_EQ(server.value("sessions_joined"), 1);
  EXPECT_EQ(server.value("kept_keyframes"), views_of_room);
  EXPECT_EQ(server.value("layer_keyframes") + server.value("layer_imageless"), 2 * views_of_room)
      << "the old map's are shown beside the new";
  server.finish();
  const auto sessions = MapFile(file()).sessions();
  ASSERT_EQ(sessions.size(), 2U);
  EXPECT_EQ(sessions[0].state, SessionState::own_frame);
  ASSERT_EQ(sessions[1].state, SessionState::joined);
  expect_near(*sessions[1].T_map_session, elsewhere().inverse());
  EXPECT_THAT(sessions[1].evidence, HasSubstr("agree"));
}

// What was seen of the old map stays; where the session has its keyframes has changed.
TEST_F(MapServerPlaces, AJoinedSessionIsPlacedAnewWhenItsGraphMovesIt) {
  map_once();
  const Eigen::Isometry3d bent = planar_pose(0.1, 0.05, 0.03) * elsewhere();
  Life server(scratch_.path(), "map", 13);
  server.drive(first_number + 2, bent);
  server.correct(first_number + 2, elsewhere());
  EXPECT_EQ(server.value("sessions_joined"), 1) << "once, however often it is placed";
  server.finish();
  const auto sessions = MapFile(file()).sessions();
  ASSERT_EQ(sessions.size(), 2U);
  expect_near(sessions[1].T_map_session.value_or(Eigen::Isometry3d::Identity()), elsewhere().inverse());
}

// Neither are derived maps left with the old map where it seemed to lie at first.
TEST_F(MapServerPlaces, DerivedMapsOfAJoinedSessionFollowWhereTheOldMapLies) {
  map_once();
  const Eigen::Isometry3d bent = planar_pose(0.1, 0.05, 0.03) * elsewhere();
  /// Share of what the old map has that stands in space by this transform, in a session that began there and
  /// was corrected.
  const auto stands = [&](const Eigen::Isometry3d& begun, const Eigen::Isometry3d& T) {
    Life server(scratch_.path(), "localise, map: " + file().string(), 13, "{background: false, rate: 0}");
    server.drive(first_number + 2, begun);
    server.correct(first_number + 2, elsewhere());
    for (int i = 0; i < 5 * views_of_room; ++i) server.work();
    server.finish();
    int all = 0, standing = 0;
    for (int k = 0; k < views_of_room; ++k) {
      const SeenView& view = seen_view(first_number + testing::frames_between * k);
      const Eigen::Isometry3d T_there = T * view.T_world_camera;
      for (std::size_t i = 0; i < view.cloud.points.size(); i += 7, ++all)
        standing += server.derived()->space().ask_occupied([&](const OccupancyGrid& occupied) {
          return occupied.state(Eigen::Vector3f(
                     (T_there * view.cloud.points[i].cast<double>()).cast<float>())) == CellState::occupied;
        });
    }
    return static_cast<double>(standing) / all;
  };
  EXPECT_GT(stands(bent, elsewhere()), 0.7);
  EXPECT_NEAR(stands(bent, bent), stands(elsewhere(), bent), 0.05)
      << "as if it had been known from the first";
}

// The mapper lives on, and its graph learns more; a joint that the server's death froze would bend the map.
TEST_F(MapServerPlaces, ASessionThatOutlivesTheServerIsPlacedAnewWhenItsGraphMovesIt) {
  map_once();
  const Eigen::Isometry3d bent = planar_pose(0.1, 0.05, 0.03) * elsewhere();
  {
    Life server(scratch_.path(), "map", 13);
    server.drive(first_number + 2, bent);
    EXPECT_EQ(server.value("sessions_joined"), 1);
    server.finish();
  }
  const Eigen::Isometry3d before = *MapFile(file()).sessions().at(1).T_map_session;
  EXPECT_GT(distance_between(before, elsewhere().inverse()), 0.05);
  Life server(scratch_.path(), "map", 13);
  const SeenView& next = seen_view(first_number + 3);
  server.track(next.features.utime, bent * next.T_world_camera);
  server.correct(first_number + 2, elsewhere());
  EXPECT_EQ(server.value("kept_keyframes"), views_of_room) << "of the old map, without the session itself";
  server.finish();
  const auto sessions = MapFile(file()).sessions();
  ASSERT_EQ(sessions.size(), 2U);
  expect_near(*sessions[1].T_map_session, elsewhere().inverse());
}

// While the server lives on.
TEST_F(MapServerPlaces, AMapperThatBeginsAnewIsJoinedToItsLastMap) {
  Life server(scratch_.path(), "map", 3);
  server.drive(first_number, Eigen::Isometry3d::Identity());
  server.drive(first_number + 2, elsewhere(), false, "map-2");
  EXPECT_EQ(server.value("sessions_joined"), 1);
  server.finish();
  const auto sessions = MapFile(file()).sessions();
  ASSERT_EQ(sessions.size(), 2U);
  ASSERT_TRUE(sessions[1].T_map_session);
  expect_near(*sessions[1].T_map_session, elsewhere().inverse());
}

// What stands in the old map stands in the robot's way all the same.
TEST_F(MapServerPlaces, DerivedMapsOfAMapperThatBeginsAnewHaveItsLastMap) {
  Life server(scratch_.path(), "map", 3, "{background: false, rate: 0}");
  server.drive(first_number, Eigen::Isometry3d::Identity());
  EXPECT_EQ(server.value("layer_keyframes"), views_of_room);
  server.drive(first_number + 2, elsewhere(), false, "map-2");  // of which no images come
  EXPECT_TRUE(testing::wait_for([&] {
    server.work();
    return server.value("layer_keyframes") == 2 * views_of_room;
  }));
  EXPECT_EQ(server.value("sessions"), 1) << "the file alone has the other one";
  EXPECT_EQ(server.value("kept_sessions"), 1);
}

TEST_F(MapServerPlaces, OfARoomMappedAgainAndAgainTheLastTwoMapsAreShown) {
  for (const std::int64_t mapper : {3, 4, 5, 6}) {
    Life server(scratch_.path(), "map", mapper);
    server.drive(first_number, Eigen::Isometry3d::Identity());
    server.finish();
  }
  Life server(scratch_.path(), "map", 13, "{background: false, rate: 0}");
  server.drive(first_number + 2, elsewhere());
  for (int i = 0; i < 5 * views_of_room; ++i) server.work();
  EXPECT_EQ(server.value("sessions_joined"), 1);
  EXPECT_EQ(server.value("layer_keyframes") + server.value("layer_imageless"), 3 * views_of_room);
}

TEST_F(MapServerPlaces, AMirrorImageOfTheRoomIsNotJoined) {
  map_once();
  Life server(scratch_.path(), "map", 13);
  server.drive(first_number + 2, elsewhere(), true);
  EXPECT_EQ(server.value("sessions_joined"), 0);
  server.finish();
  EXPECT_FALSE(MapFile(file()).sessions().at(1).T_map_session);
}

TEST_F(MapServerPlaces, WhoLocalisesWritesNothing) {
  map_once();
  const std::string before = scratch_.read("map.lcmslam");
  testing::ScratchFolder run;
  Life server(run.path(), "localise, map: " + file().string(), 13);
  server.drive(first_number + 2, elsewhere());
  EXPECT_EQ(server.value("sessions_joined"), 1);
  server.finish();
  EXPECT_EQ(scratch_.read("map.lcmslam"), before);
  EXPECT_FALSE(std::filesystem::exists(run.path() / "map.lcmslam"));
}

TEST_F(MapServerPlaces, AMapThatIsNotThereIsNamed) {
  EXPECT_THAT(
      [&] { Life(scratch_.path(), "localise, map: " + (scratch_.path() / "no.lcmslam").string(), 13); },
      ::testing::ThrowsMessage<std::runtime_error>(HasSubstr("no.lcmslam")));
  EXPECT_ANY_THROW(Life(scratch_.path(), "localise", 13)) << "which map?";
}

TEST_F(MapServerPlaces, WhoAsksIsToldWhereHeIs) {
  Life server(scratch_.path(), "map", 3);
  server.drive(first_number, elsewhere());
  server.look(first_number + 2);
  const json here = server.localise();
  ASSERT_EQ(here["found"], true) << here.dump();
  expect_near(pose_of(here["camera"]), elsewhere() * seen_view(first_number + 2).T_world_camera);
  EXPECT_EQ(here["covariance"].size(), 21U);
  EXPECT_GT(here["evidence"]["features"], 14);
}

// Else memory grows with the way, whatever the mapper's bounds.
TEST_F(MapServerPlaces, WhatTheMapperHasGivenUpIsNoPlaceAnyMore) {
  Life server(scratch_.path(), "map", 3);
  server.drive(first_number, Eigen::Isometry3d::Identity());
  EXPECT_EQ(server.value("places"), views_of_room);
  server.give_up({1, 4});
  EXPECT_EQ(server.value("places"), views_of_room - 2);
}

TEST_F(MapServerPlaces, ARestartedServerKnowsTheOldMap) {
  map_once();
  Life server(scratch_.path(), "map", 13);
  server.look(first_number + 2);
  const json here = server.localise();
  ASSERT_EQ(here["found"], true) << here.dump();
  EXPECT_EQ(here["frame"], "the file's map");
  expect_near(pose_of(here["camera"]), seen_view(first_number + 2).T_world_camera);
}

}  // namespace
}  // namespace lcmslam
