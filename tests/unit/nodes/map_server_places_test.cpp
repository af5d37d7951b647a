// Sessions that begin anywhere find their place in the map of the file, and who is lost his, in the simulated
// kitchen, where all places are known.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include "procs/map-server/map_server_node.hpp"
#include "tests/support/seen_kitchen.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::seen_view;
using testing::SeenView;
using testing::SimulatedKitchen;
using testing::value_of;

constexpr int views_of_room = 6, first_number = 60, frames_between = 5;

/// One life of a map server.
class Life {
 public:
  Life(const std::filesystem::path& folder, const std::string& mode, std::int64_t mapper,
       const std::string& layers = "{make: false, background: false}")
      : node_(bus_.add<MapServerNode>(ConfigNode::parse("{folder: " + folder.string() + ", mode: " + mode +
                                                        ", layers: " + layers + "}"))),
        mapper_(mapper) {
    bus_.deliver("CAMERA_CALIBRATION", SimulatedKitchen::instance().calibration());
  }
  /// Keyframes of every frames_between-th frame from there; a mirror image of them is no place of the
  /// kitchen.
  void drive(int from, const Eigen::Isometry3d& T_map_world, bool mirrored = false,
             const std::string& frame = "map") {
    const Utime later = frame == "map" ? 0 : 60'000'000;
    frame_ = frame;
    const RgbdCalibration& calibration = SimulatedKitchen::instance().simulation().calibration();
    for (int k = 0; k < views_of_room; ++k) {
      const SeenView& known = seen_view(from + frames_between * k);
      SeenView view = mirrored ? known.mirrored() : known;
      view.features.utime += later;
      const Eigen::Isometry3d T_map_camera = T_map_world * view.T_world_camera;
      if (later == 0) bus_.deliver("CAMERA", *view.images);
      track(view.features.utime, T_map_camera);
      send("FEATURES", to_message(view.features));
      DenseKeyframe keyframe{k, view.features.utime, T_map_camera, view.cloud, 0};
      for (const keyframe_t& tile : make_keyframe_tiles(keyframe, calibration.T_robot_camera, k + 1))
        send("ICP_KEYFRAME", tile);
      bus_.work();
    }
    for (int k = 0; k < 2 * views_of_room; ++k) bus_.work();
  }
  /// The mapper says where it is.
  void track(Utime utime, const Eigen::Isometry3d& T_map_camera) {
    const RgbdCalibration& calibration = SimulatedKitchen::instance().simulation().calibration();
    pose_estimate_t pose = make_pose_estimate(utime, T_map_camera * calibration.T_robot_camera.inverse(),
                                              Matrix6d::Identity() * 1e-6);
    pose.status = pose_estimate_t::TRACKING;
    send("ICP_POSE", pose);
  }
  json localise() {
    map_request_t request{};
    request.request_id = ++seq_;
    request.kind = map_request_t::QUERY;
    request.argument = R"({"ask": "localise"})";
    bus_.deliver("MAP_REQUEST", request);
    bus_.work();
    const map_reply_t reply = bus_.on<map_reply_t>("MAP_REPLY").back();
    EXPECT_EQ(reply.status, 0) << reply.message;
    return json::parse(reply.data.begin(), reply.data.end());
  }
  /// Features of a frame of which the map has no keyframe.
  void look(int number) { send("FEATURES", to_message(seen_view(number).features)); }
  void give_up(const std::vector<std::int32_t>& keyframes) {
    graph_t graph{};
    graph.change = 1;
    graph.gone = keyframes;
    graph.n_gone = static_cast<std::int32_t>(keyframes.size());
    send("ICP_GRAPH", graph);
  }
  /// The graph says that the keyframes of drive(from, ...) lie there.
  void correct(int from, const Eigen::Isometry3d& T_map_world) {
    graph_t graph{};
    for (int k = 0; k < views_of_room; ++k) {
      const SeenView& view = seen_view(from + frames_between * k);
      graph.nodes.push_back({k, view.features.utime, to_message(T_map_world * view.T_world_camera)});
    }
    graph.n_nodes = views_of_room;
    graph.map_revision = views_of_room;
    send("ICP_GRAPH", graph);
    bus_.work();
  }
  double value(const std::string& name) { return value_of(node_, name); }
  void work() { bus_.work(); }
  void finish() { bus_.finish(); }

 private:
  template <class M>
  void send(const std::string& channel, M message) {
    message.seq = seq_++;
    message.sender = mapper_;
    if constexpr (!std::is_same_v<M, features_t>) message.frame = frame_;
    bus_.deliver(channel, message);
  }
  testing::TestBus bus_;
  MapServerNode& node_;
  std::int64_t mapper_, seq_ = 0;
  std::string frame_ = "map";
};

class MapServerPlaces : public ::testing::Test {
 protected:
  std::filesystem::path file() const { return scratch_.path() / "map.lcmslam"; }
  void map_once() {
    Life server(scratch_.path(), "map", 3);
    server.drive(first_number, Eigen::Isometry3d::Identity());
    EXPECT_EQ(server.value("sessions_joined"), 0);
    server.finish();
  }
  static Eigen::Isometry3d elsewhere() {
    return Eigen::Translation3d(2, -1, 0) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) *
           Eigen::Isometry3d::Identity();
  }
  static void expect_near(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    EXPECT_LT(distance_between(a, b), 0.02);
    EXPECT_LT(angle_between(a, b), 0.01);
  }
  static Eigen::Isometry3d pose_of(const json& pose) {
    const auto p = pose["position"].get<std::array<double, 3>>();
    const auto q = pose["quaternion"].get<std::array<double, 4>>();
    return make_transform(p.data(), q.data());
  }

  testing::ScratchFolder scratch_;
};

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
