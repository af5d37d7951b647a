// The map's first session goes on while the map server is restarted: what its mapper learns then counts for
// who begins anew.

#include "tests/unit/nodes/map_server_places_fixture.hpp"

namespace lcmslam {
namespace {

using testing::first_number;
using testing::Life;
using testing::seen_view;
using testing::SeenView;

constexpr int another_part = 200;  // frame from which other furniture is seen

class MapServerRestartPlaces : public testing::MapServerPlaces {
 protected:
  /// The pose that the mapper's graph corrects later.
  static Eigen::Isometry3d bent() { return planar_pose(0.1, 0.05, 0.03); }
  void map_bent() {
    Life server(scratch_.path(), "map", 3);
    server.drive(first_number, bent());
    server.finish();
  }
  static void hear(Life& server, const Eigen::Isometry3d& T_map_world) {
    const SeenView& next = seen_view(first_number + 3);
    server.track(next.features.utime, T_map_world * next.T_world_camera);
  }
  void expect_second_joined() const {
    const auto sessions = MapFile(file()).sessions();
    ASSERT_EQ(sessions.size(), 2U);
    ASSERT_TRUE(sessions[1].T_map_session);
    expect_near(*sessions[1].T_map_session, elsewhere().inverse());
  }
};

TEST_F(MapServerRestartPlaces, WhereItsGraphMovesItOthersAreJoined) {
  map_bent();
  Life server(scratch_.path(), "map", 3);
  hear(server, bent());
  server.correct(first_number, Eigen::Isometry3d::Identity());
  server.drive(first_number + 2, elsewhere(), false, "map-2");
  EXPECT_EQ(server.value("sessions_joined"), 1);
  server.finish();
  expect_second_joined();
}

TEST_F(MapServerRestartPlaces, WhatItMapsNowIsFoundByOthers) {
  map_once();
  Life server(scratch_.path(), "map", 3);
  server.goes_on_from(testing::views_of_room);
  server.drive(another_part, Eigen::Isometry3d::Identity());
  server.drive(another_part + 2, elsewhere(), false, "map-2");
  EXPECT_EQ(server.value("sessions_joined"), 1);
  server.finish();
  expect_second_joined();
}

TEST_F(MapServerRestartPlaces, WhatItGivesUpIsNoPlaceAnyMore) {
  map_once();
  Life server(scratch_.path(), "map", 3);
  hear(server, Eigen::Isometry3d::Identity());
  EXPECT_EQ(server.value("kept_keyframes"), testing::views_of_room);
  server.correct(first_number, Eigen::Isometry3d::Identity());
  server.give_up({1, 4});
  EXPECT_EQ(server.value("kept_keyframes"), testing::views_of_room - 2);
}

// Derived maps are shown the file's keyframes.
TEST_F(MapServerRestartPlaces, WhatIsKeptLiesWhereTheFileHasItNow) {
  map_bent();
  SessionPlaces places(file(), false);
  {
    Life server(scratch_.path(), "map", 3);
    hear(server, bent());
    server.correct(first_number, Eigen::Isometry3d::Identity());
    server.finish();
  }
  places.keep(MapFile(file()).sessions().at(0).id);
  places.begin_session(0);
  for (int k = 0; k < testing::views_of_room; ++k) {
    const SeenView& view = seen_view(first_number + 2 + testing::frames_between * k);
    places.keyframe(k, view.T_world_camera, view.features, view.cloud);
  }
  const auto first = places.next_kept();
  ASSERT_TRUE(first) << "it was not joined";
  expect_near(*places.T_map_session() * first->T_session_camera, seen_view(first_number).T_world_camera);
}

// Two keyframes that lay wrong outvote those that lie right, until the mapper gives them up.
TEST_F(MapServerRestartPlaces, WhatWasGivenUpHasNoSayInWhereASessionLies) {
  map_once();
  SessionPlaces places(file(), false);
  places.begin_session(0);
  for (int k = 0; k < testing::views_of_room; ++k) {
    const SeenView& view = seen_view(first_number + testing::frames_between * k);
    const Eigen::Isometry3d slip = k < 2 ? planar_pose(2, 1, 0.5) : Eigen::Isometry3d::Identity();
    places.keyframe(k, slip * elsewhere() * view.T_world_camera, view.features, view.cloud);
  }
  EXPECT_FALSE(places.T_map_session());
  places.correct({}, {0, 1});
  ASSERT_TRUE(places.T_map_session());
  expect_near(*places.T_map_session(), elsewhere().inverse());
}

// The file has the room, the session another part of the kitchen and, far from both, the room's twin: either
// map alone is sure.
TEST_F(MapServerRestartPlaces, WhoMayBeInTheFilesMapOrInItsTwinIsNotFound) {
  {
    Life server(scratch_.path(), "map", 3);
    server.drive(first_number, Eigen::Isometry3d::Identity());
    server.goes_on_from(testing::views_of_room);
    server.drive(another_part, Eigen::Isometry3d::Identity());
    server.finish();
  }
  SessionPlaces places(file(), false);
  places.begin_session(0);
  const auto drive = [&](int from, int id, const Eigen::Isometry3d& T_session_world) {
    for (int k = 0; k < testing::views_of_room; ++k) {
      const SeenView& view = seen_view(from + testing::frames_between * k);
      places.keyframe(id + k, T_session_world * view.T_world_camera, view.features, view.cloud);
    }
  };
  const FeatureFrame& asker = seen_view(first_number + 2).features;
  drive(another_part, 0, elsewhere());
  ASSERT_TRUE(places.T_map_session());
  const auto in_map = places.locate(asker);
  ASSERT_TRUE(in_map.located.place) << in_map.located.why_not;
  expect_near(in_map.located.place->T_map_camera, elsewhere() * seen_view(first_number + 2).T_world_camera);
  drive(first_number, 100, Eigen::Translation3d(30, 0, 0) * elsewhere());
  const auto twin = places.locate(asker);
  EXPECT_FALSE(twin.located.place);
  EXPECT_THAT(twin.located.why_not, ::testing::HasSubstr("two places look alike"));
}

}  // namespace
}  // namespace lcmslam
