// What the file of earlier runs lacks, or has damaged, takes nothing else away.

#include <memory>

#include "tests/unit/nodes/map_server_places_fixture.hpp"
#include "tests/unit/nodes/map_server_store_fixture.hpp"

namespace lcmslam {
namespace {

using testing::first_number;
using testing::Life;
using testing::seen_view;
using testing::SeenView;
using testing::value_of;

class MapServerOldFile : public testing::MapServerPlaces {
 protected:
  void execute(const std::string& sql) { Database(file(), Database::Access::write).execute(sql); }
  void map_from(std::int64_t mapper, const Eigen::Isometry3d& T_session_world) {
    Life server(scratch_.path(), "map", mapper);
    server.drive(first_number + 2, T_session_world);
    server.finish();
  }
  /// The mapper begins twice: whether its second session is joined, to the first or whatever else.
  static bool joins_two_sessions(SessionPlaces& places) {
    for (const Eigen::Isometry3d& T_session_world : {Eigen::Isometry3d::Identity(), elsewhere()}) {
      places.begin_session(0);
      for (int k = 0; k < testing::views_of_room; ++k) {
        const SeenView& view = seen_view(first_number + testing::frames_between * k);
        places.keyframe(k, T_session_world * view.T_world_camera, view.features, view.cloud);
      }
    }
    return !places.take_joined().empty();
  }
};

TEST_F(MapServerOldFile, ADamagedKeyframeIsTheOnlyOneThatIsNotFound) {
  map_once();
  execute("UPDATE features SET data = zeroblob(length(data)) WHERE keyframe = 1");
  execute("UPDATE cloud SET data = zeroblob(length(data)) WHERE keyframe = 2");
  const SessionPlaces places(file(), false);
  EXPECT_EQ(places.kept_keyframes(), testing::views_of_room - 2U);
  EXPECT_THAT(places.error(), ::testing::HasSubstr("keyframe 2"));
  map_from(13, elsewhere());
  const auto sessions = MapFile(file()).sessions();
  ASSERT_EQ(sessions.size(), 2U);
  ASSERT_TRUE(sessions[1].T_map_session);
  expect_near(*sessions[1].T_map_session, elsewhere().inverse());
  map_from(23, elsewhere());
  EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "icp-session1_map.ply"));
  EXPECT_TRUE(std::filesystem::exists(scratch_.path() / "icp-session2_map.ply"));
}

TEST_F(MapServerOldFile, OtherSessionsAreFoundBesideADamagedOne) {
  map_once();
  map_from(13, elsewhere());
  execute("UPDATE keyframe SET pose = zeroblob(10) WHERE session = 1");
  EXPECT_EQ(SessionPlaces(file(), false).kept_keyframes(), testing::views_of_room);
}

TEST_F(MapServerOldFile, ADamagedPoseTakesNothingElseAway) {
  map_once();
  map_from(13, elsewhere());
  execute("UPDATE keyframe SET pose = zeroblob(10) WHERE session = 1 AND id = 2");
  const MapRecorder recorder(file(), "");
  EXPECT_EQ(recorder.kept().size(), 2U);
  EXPECT_EQ(recorder.error(), "") << "all can be written";
  EXPECT_THAT(recorder.damage(), ::testing::HasSubstr("keyframe 2 of session 1"));
  execute("DELETE FROM session WHERE id = 2");
  const SessionPlaces places(file(), false);
  EXPECT_EQ(places.kept_keyframes(), testing::views_of_room - 1U);
  EXPECT_THAT(places.error(), ::testing::HasSubstr("keyframe 2 of session 1"));
}

TEST_F(MapServerOldFile, AFolderThatMayNotBeEnteredEndsNobody) {
  std::filesystem::create_directory_symlink("round", scratch_.path() / "round");
  const auto nowhere = scratch_.path() / "round" / "map.lcmslam";
  EXPECT_NE(SessionPlaces(nowhere, false).error(), "");
  EXPECT_NE(LandmarkSessions(nowhere, false).error(), "");
  EXPECT_NE(MapRecorder(nowhere, "").error(), "");
}

TEST_F(MapServerOldFile, ASessionWhosePlaceIsDamagedIsLookedForAgain) {
  map_once();
  map_from(13, elsewhere());
  execute("UPDATE session SET T_map_session = zeroblob(10) WHERE id = 2");
  EXPECT_THROW(MapFile(file()).sessions(), StoreError);
  Life server(scratch_.path(), "map", 23);
  EXPECT_GT(server.value("kept_sessions"), 1);
  server.work();
  server.finish();
  const auto sessions = MapFile(file()).sessions();
  ASSERT_TRUE(sessions.at(1).T_map_session);
  expect_near(*sessions[1].T_map_session, elsewhere().inverse());
}

// As `map compact` holds it.
class MapServerHeldFile : public MapServerOldFile {
 protected:
  std::unique_ptr<Database> hold() {
    auto other = std::make_unique<Database>(file(), Database::Access::write);
    other->execute("PRAGMA locking_mode = EXCLUSIVE; BEGIN EXCLUSIVE; COMMIT");
    return other;
  }
};

TEST_F(MapServerHeldFile, OnceItIsFreeSessionsAreFoundInIt) {
  map_once();
  auto other = hold();
  Life server(scratch_.path(), "map", 13);
  server.drive(first_number, Eigen::Isometry3d::Identity());
  EXPECT_EQ(server.value("kept_sessions"), 0);
  other.reset();
  const auto is_read = [&] {
    server.work();
    return server.value("kept_sessions") == 1 && server.value("kept_keyframes") >= testing::views_of_room;
  };
  EXPECT_TRUE(testing::wait_for(is_read));
  server.drive(first_number + 2, elsewhere(), false, "map-2");
  EXPECT_EQ(server.value("sessions_joined"), 1);
  server.finish();
  const auto sessions = MapFile(file()).sessions();
  ASSERT_EQ(sessions.size(), 3U);
  EXPECT_FALSE(sessions[1].T_map_session) << "the file was not there to be looked in";
  ASSERT_TRUE(sessions[2].T_map_session);
  expect_near(*sessions[2].T_map_session, elsewhere().inverse());
}

// The server was restarted, the mapper was not. It is told the graph while the file is held, or its whole map
// after that is free.
TEST_F(MapServerHeldFile, ASessionWhoseMapperLivesOnGoesOnInIt) {
  map_once();
  map_from(13, elsewhere());
  for (const bool told_while_held : {true, false}) {
    auto other = hold();
    Life server(scratch_.path(), "map", 13);
    const auto tell_graph = [&] { server.correct(first_number + 2, elsewhere(), {2}); };
    server.track(seen_view(first_number).features.utime, Eigen::Isometry3d::Identity());
    if (told_while_held) tell_graph();
    other.reset();
    EXPECT_TRUE(testing::wait_for([&] { return server.work(), server.value("kept_sessions") == 1; }));
    if (!told_while_held) {
      server.drive(first_number + 2, elsewhere());
      tell_graph();
    }
    server.finish();
    const auto sessions = MapFile(file()).sessions();
    ASSERT_EQ(sessions.size(), 2U);
    EXPECT_EQ(MapFile(file()).keyframes(2).size(), testing::views_of_room - 1U) << "its graph gave one up";
    ASSERT_TRUE(sessions[1].T_map_session);
    expect_near(*sessions[1].T_map_session, elsewhere().inverse());
    EXPECT_THAT(check_map_file(file()).faults, ::testing::IsEmpty());
  }
}

TEST_F(MapServerHeldFile, LandmarksOfAMapperThatLivesOnGoOnInIt) {
  const auto run = scratch_.path();
  {
    testing::StoringServer server(run);
    server.landmarks(1, 0, {10, 11, 12});
    server.finish();
  }
  auto other = hold();
  testing::StoringServer server(run);
  server.landmarks(2, 1, {13});  // a change alone
  other.reset();
  EXPECT_TRUE(testing::wait_for([&] {
    server.bus().work();
    return value_of(server.node(), "store_commits") > 0;
  }));
  server.landmarks(3, 0, {10, 11, 13, 14});
  server.finish();
  ASSERT_EQ(MapFile(file()).sessions().size(), 1U);
  EXPECT_EQ(MapFile(file()).landmarks(1).size(), 4U);
}

// The file's map has a frame, which is not that of the first session that is heard: what were joined to that
// would be written down, and lie wrong for every later server.
TEST_F(MapServerHeldFile, WhereItCannotBeReadNoSessionMakesTheMapsFrame) {
  {
    SessionPlaces no_file(file(), false);
    EXPECT_TRUE(joins_two_sessions(no_file));
  }
  map_once();
  {
    const auto other = hold();
    SessionPlaces locked(file(), false);
    EXPECT_THAT(locked.error(), ::testing::HasSubstr("locked"));
    EXPECT_FALSE(joins_two_sessions(locked));
  }
  execute("UPDATE keyframe SET pose = zeroblob(10)");
  SessionPlaces damaged(file(), false);
  EXPECT_FALSE(joins_two_sessions(damaged));
}

// Nothing can be found in it, so later sessions share the frame of the next one, and all say so.
TEST_F(MapServerOldFile, ASessionWithoutFeaturesIsNotTheMapsFrame) {
  map_once();
  execute("DELETE FROM features");
  map_from(13, Eigen::Isometry3d::Identity());
  map_from(23, elsewhere());
  const auto sessions = MapFile(file()).sessions();
  ASSERT_EQ(sessions.size(), 3U);
  EXPECT_FALSE(sessions[0].T_map_session);
  EXPECT_FALSE(sessions[1].T_map_session);
  ASSERT_TRUE(sessions[2].T_map_session);
  expect_near(*sessions[2].T_map_session, elsewhere().inverse());
  EXPECT_EQ(MapFile(file()).frame_session("icp"), sessions[1].id);
  const MapRecorder recorder(file(), "");
  EXPECT_EQ(recorder.evidence(sessions[0].id), std::nullopt) << "it lies apart";
  EXPECT_EQ(recorder.evidence(sessions[1].id), "");
  EXPECT_THAT(recorder.evidence(sessions[2].id).value_or(""), ::testing::HasSubstr("agree"));
}

}  // namespace
}  // namespace lcmslam
