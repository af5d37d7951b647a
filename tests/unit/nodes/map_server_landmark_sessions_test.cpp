// Sessions of FastSLAM that begin anywhere find their place in the landmarks of the file.

#include <gmock/gmock.h>

#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include "procs/map-server/map_server_node.hpp"
#include "tests/support/landmark_room.hpp"
#include "tests/support/test_bus.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using testing::value_of;
using testing_scene::LandmarkRoom;

/// One life of a map server.
class LandmarkLife {
 public:
  LandmarkLife(const std::filesystem::path& folder, const std::string& mode, std::int64_t mapper)
      : node_(bus_.add<MapServerNode>(ConfigNode::parse("{folder: " + folder.string() + ", mode: " + mode +
                                                        ", layers: {make: false, background: false}}"))),
        mapper_(mapper) {}

  /// The mapper tells these, as many at a time as it finds in some frames.
  void drive(const std::vector<Landmark>& landmarks, const std::string& frame = "map") {
    std::int64_t& revision = revisions_[frame];
    for (std::size_t i = 0; i < landmarks.size(); i += 25) {
      track(frame);
      const auto end = std::min(landmarks.size(), i + 25);
      const auto at = [&](std::size_t k) { return landmarks.begin() + static_cast<std::ptrdiff_t>(k); };
      for (landmarks_t& told : make_landmark_tiles(utime_, 0, 0, {at(i), at(end)}, {})) {
        told.base_revision = revision;
        told.map_revision = ++revision;
        told.tile = 0;
        told.n_tiles = 1;
        send("FASTSLAM_LANDMARKS", told, frame);
      }
      bus_.work();
    }
    bus_.work();
  }
  /// The mapper is asked for all that it has.
  void tell_all(const std::vector<Landmark>& landmarks) {
    track("map");
    for (const landmarks_t& tile : make_landmark_tiles(utime_, ++revisions_["map"], 0, landmarks, {}))
      send("FASTSLAM_LANDMARKS", tile, "map");
    bus_.work();
  }
  /// The mapper has told so many changes before this server began.
  void goes_on_from(std::int64_t revision) { revisions_["map"] = revision; }
  double value(const std::string& name) { return value_of(node_, name); }
  void finish() { bus_.finish(); }

 private:
  void track(const std::string& frame) {
    utime_ += 1'000'000;
    pose_estimate_t pose =
        make_pose_estimate(utime_, Eigen::Isometry3d::Identity(), Matrix6d::Identity() * 1e-6);
    pose.status = pose_estimate_t::TRACKING;
    send("FASTSLAM_POSE", pose, frame);
  }
  template <class M>
  void send(const std::string& channel, M message, const std::string& frame) {
    message.seq = seq_++;
    message.sender = mapper_;
    message.frame = frame;
    bus_.deliver(channel, message);
  }
  testing::TestBus bus_;
  MapServerNode& node_;
  std::int64_t mapper_, seq_ = 0;
  std::map<std::string, std::int64_t> revisions_;  // by frame
  Utime utime_ = 1'000'000;
};

class MapServerLandmarkSessions : public ::testing::Test {
 protected:
  std::filesystem::path file() const { return scratch_.path() / "map.lcmslam"; }
  void map_once() {
    LandmarkLife server(scratch_.path(), "map", 3);
    server.drive(room.mapped(Eigen::Isometry3d::Identity(), 1));
    EXPECT_EQ(server.value("landmark_sessions_joined"), 0);
    server.finish();
  }
  static Eigen::Isometry3d elsewhere() { return planar_pose(2, -1, 0.7); }
  static Eigen::Isometry3d bent() { return planar_pose(0.1, 0.05, 0.03) * elsewhere(); }
  void expect_joined(std::size_t sessions) const {
    const auto kept = MapFile(file()).sessions();
    ASSERT_EQ(kept.size(), sessions);
    EXPECT_EQ(kept.front().state, SessionState::own_frame);
    ASSERT_EQ(kept.back().state, SessionState::joined);
    EXPECT_LT(distance_between(*kept.back().T_map_session, elsewhere().inverse()), 0.03);
    EXPECT_LT(angle_between(*kept.back().T_map_session, elsewhere().inverse()), 0.01);
    EXPECT_THAT(kept.back().evidence, HasSubstr("groups of landmarks"));
  }

  testing::ScratchFolder scratch_;
  LandmarkRoom room{1};
};

TEST_F(MapServerLandmarkSessions, OneThatBeginsElsewhereIsJoined) {
  map_once();
  LandmarkLife server(scratch_.path(), "map", 13);
  EXPECT_GT(server.value("kept_landmarks"), 400);
  server.drive(room.mapped(elsewhere(), 2));
  EXPECT_EQ(server.value("landmark_sessions_joined"), 1);
  EXPECT_EQ(server.value("sessions_joined"), 0) << "there is no dense one";
  server.finish();
  expect_joined(2);
}

// What was not certain while it ran is looked for again, whole, when the next server begins.
TEST_F(MapServerLandmarkSessions, OneOfAnEarlierRunIsLookedForAgain) {
  map_once();
  {
    LandmarkLife without(scratch_.path(), "map, places: false", 13);
    without.drive(room.mapped(elsewhere(), 2));
    without.finish();
  }
  EXPECT_FALSE(MapFile(file()).sessions().back().T_map_session);
  LandmarkLife server(scratch_.path(), "map", 23);
  server.drive({});
  server.finish();
  expect_joined(2);
}

TEST_F(MapServerLandmarkSessions, OneThatWasJoinedFollowsItsMap) {
  map_once();
  LandmarkLife server(scratch_.path(), "map", 13);
  server.drive(room.mapped(bent(), 2));
  server.drive(room.mapped(elsewhere(), 2));
  EXPECT_EQ(server.value("landmark_sessions_joined"), 1) << "once, however often it is placed";
  server.finish();
  expect_joined(2);
}

// The mapper lives on and learns more; a joint that the server's death froze would bend the map.
TEST_F(MapServerLandmarkSessions, OneThatOutlivesTheServerIsPlacedAnewAsItsMapMoves) {
  map_once();
  double kept = 0;
  {
    LandmarkLife server(scratch_.path(), "map", 13);
    kept = server.value("kept_landmarks");
    server.drive(room.mapped(bent(), 2));
    EXPECT_EQ(server.value("landmark_sessions_joined"), 1);
    server.finish();
  }
  const Eigen::Isometry3d before = *MapFile(file()).sessions().at(1).T_map_session;
  EXPECT_GT(distance_between(before, elsewhere().inverse()), 0.05);
  LandmarkLife server(scratch_.path(), "map", 13);
  server.goes_on_from(1000);
  server.drive(room.mapped(elsewhere(), 2));
  EXPECT_EQ(server.value("kept_landmarks"), kept) << "of the old map, without the session itself";
  server.finish();
  expect_joined(2);
}

// The map's first session goes on, too.
TEST_F(MapServerLandmarkSessions, WhatTheFirstOneLearnsAfterARestartCountsForOthers) {
  {
    LandmarkLife server(scratch_.path(), "map", 3);
    server.drive(room.mapped(planar_pose(0.1, 0.05, 0.03), 1));
    server.finish();
  }
  LandmarkLife server(scratch_.path(), "map", 3);
  server.tell_all(room.mapped(Eigen::Isometry3d::Identity(), 1));
  server.drive(room.mapped(elsewhere(), 2), "map-2");
  EXPECT_EQ(server.value("landmark_sessions_joined"), 1);
  server.finish();
  expect_joined(2);
}

TEST_F(MapServerLandmarkSessions, APartOfTheFirstOneLeavesTheFilesWhole) {
  map_once();
  LandmarkLife server(scratch_.path(), "map", 3);
  const double kept = server.value("kept_landmarks");
  server.goes_on_from(1000);
  const auto all = room.mapped(Eigen::Isometry3d::Identity(), 1);
  server.drive({all.begin(), all.begin() + 50});
  server.drive(room.mapped(elsewhere(), 2), "map-2");
  EXPECT_GE(server.value("kept_landmarks"), kept);
  EXPECT_EQ(server.value("landmark_sessions_joined"), 1);
  server.finish();
  expect_joined(2);
}

TEST_F(MapServerLandmarkSessions, AMapperThatBeginsAnewIsJoinedToItsLastMap) {
  LandmarkLife server(scratch_.path(), "map", 3);
  server.drive(room.mapped(Eigen::Isometry3d::Identity(), 1));
  server.drive(room.mapped(elsewhere(), 2), "map-2");
  EXPECT_EQ(server.value("landmark_sessions_joined"), 1);
  server.finish();
  expect_joined(2);
}

TEST_F(MapServerLandmarkSessions, AnotherRoomIsNotJoined) {
  map_once();
  LandmarkLife server(scratch_.path(), "map", 13);
  server.drive(LandmarkRoom(2).mapped(elsewhere(), 2));
  EXPECT_EQ(server.value("landmark_sessions_joined"), 0);
  server.finish();
  EXPECT_FALSE(MapFile(file()).sessions().back().T_map_session);
}

TEST_F(MapServerLandmarkSessions, WhereTheFirstOneIsDamagedNoOtherMakesTheMapsFrame) {
  map_once();
  Database(file(), Database::Access::write)
      .execute("UPDATE landmark SET data = zeroblob(10) WHERE id = (SELECT min(id) FROM landmark)");
  EXPECT_THAT(LandmarkSessions(file(), false).error(), HasSubstr("landmark "));
  LandmarkLife server(scratch_.path(), "map", 13);
  server.drive(room.mapped(Eigen::Isometry3d::Identity(), 2));
  server.drive(room.mapped(elsewhere(), 3), "map-2");
  EXPECT_EQ(server.value("landmark_sessions_joined"), 0);
}

TEST_F(MapServerLandmarkSessions, ADamagedOneTakesNoOtherAway) {
  map_once();
  {
    LandmarkLife server(scratch_.path(), "map", 13);
    server.drive(room.mapped(elsewhere(), 2));
    server.finish();
  }
  Database(file(), Database::Access::write)
      .execute("UPDATE landmark SET data = zeroblob(10) WHERE session = 1");
  EXPECT_GT(LandmarkSessions(file(), false).kept_landmarks(), 100U);
}

TEST_F(MapServerLandmarkSessions, WhoLocalisesWritesNothing) {
  map_once();
  const std::string before = scratch_.read("map.lcmslam");
  testing::ScratchFolder run;
  LandmarkLife server(run.path(), "localise, map: " + file().string(), 13);
  server.drive(room.mapped(elsewhere(), 2));
  EXPECT_EQ(server.value("landmark_sessions_joined"), 1);
  server.finish();
  EXPECT_EQ(scratch_.read("map.lcmslam"), before);
}

}  // namespace
}  // namespace lcmslam
