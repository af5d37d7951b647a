// What the map server answers to questions, in the simulated kitchen, whose surfaces are known.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include <lcmslam/map_query/question.hpp>
#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include "procs/map-server/map_server_node.hpp"
#include "tests/support/simulated_kitchen.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::SimulatedKitchen;
using testing::value_of;

constexpr int frames = 12, keyframe_every = 3;

/// Of the kitchen's frames: three a second, while it turns.
int number(int k) {
  return 60 + 3 * k;
}

class MapServerQuestions : public ::testing::Test {
 protected:
  /// Frames with their true poses, every third one a keyframe that stands `shift` beside its place.
  void drive(const Eigen::Vector3d& shift = Eigen::Vector3d::Zero()) { drive(bus_, shift, true); }
  void drive(testing::TestBus& bus, const Eigen::Vector3d& shift, bool with_images) {
    SimulatedKitchen& kitchen = SimulatedKitchen::instance();
    bus.deliver("CAMERA_CALIBRATION", kitchen.calibration());
    const RgbdCalibration calibration = kitchen.simulation().calibration();
    for (int k = 0; k < frames; ++k) {
      const images_t& images = kitchen.frame(number(k));
      if (with_images) bus.deliver("CAMERA", images);
      const EncodedFrame frame = from_message(images);
      const Utime depth_time = calibration.depth_time(frame.depth.utime);
      pose_estimate_t pose =
          make_pose_estimate(depth_time, T_world_robot(depth_time, shift), Matrix6d::Identity() * 1e-6);
      pose.seq = k;
      pose.sender = 3;
      pose.frame = "map";
      pose.status = pose_estimate_t::TRACKING;
      bus.deliver("ICP_POSE", pose);
      if (k % keyframe_every != 0) continue;
      DenseKeyframe keyframe;
      keyframe.id = k;
      keyframe.utime = frame.utime;
      keyframe.T_world_camera = T_world_robot(frame.utime, shift) * calibration.T_robot_camera;
      keyframe.cloud.points = {{0, 0, 1}, {0.1F, 0, 1}, {0, 0, 2}};
      keyframe.cloud.colours.resize(3, {10, 20, 30});
      for (keyframe_t& tile : make_keyframe_tiles(keyframe, calibration.T_robot_camera, k + 1)) {
        tile.seq = seq_++;
        tile.sender = 3;
        tile.frame = "map";
        bus.deliver("ICP_KEYFRAME", tile);
      }
    }
  }
  static Eigen::Isometry3d T_world_robot(Utime utime, const Eigen::Vector3d& shift) {
    return Eigen::Translation3d(shift) * SimulatedKitchen::instance().simulation().T_world_robot(utime);
  }
  /// The graph takes the keyframes to their true places.
  void correct() {
    graph_t graph{};
    graph.utime = 1;
    graph.frame = "map";
    graph.sender = 3;
    const RgbdCalibration calibration = SimulatedKitchen::instance().simulation().calibration();
    for (int k = 0; k < frames; k += keyframe_every) {
      graph_node_t node;
      node.keyframe = k;
      node.keyframe_utime = SimulatedKitchen::instance().frame_time(number(k));
      node.T_map_camera =
          to_message(T_world_robot(node.keyframe_utime, {0, 0, 0}) * calibration.T_robot_camera);
      graph.nodes.push_back(node);
    }
    graph.n_nodes = static_cast<std::int32_t>(graph.nodes.size());
    graph.map_revision = graph.n_nodes;
    bus_.deliver("ICP_GRAPH", graph);
  }

  /// All tiles' data, one after the other; `last` is one of them.
  std::string ask(const std::string& question) {
    map_request_t request{};
    request.utime = 7;
    request.request_id = ++seq_;
    request.sender = 77;
    request.kind = map_request_t::QUERY;
    request.argument = question;
    bus_.deliver("MAP_REQUEST", request);
    bus_.work();
    std::string bytes;
    int tiles = 0;
    for (const map_reply_t& tile : bus_.on<map_reply_t>("MAP_REPLY")) {
      if (tile.request_id != request.request_id) continue;
      EXPECT_EQ(tile.tile, tiles++);
      last = tile;
      bytes.append(tile.data.begin(), tile.data.end());
    }
    EXPECT_EQ(tiles, last.n_tiles);
    return bytes;
  }
  json answer(const std::string& question) {
    const std::string bytes = ask(question);
    EXPECT_EQ(last.status, 0) << last.message;
    return json::parse(bytes);
  }
  std::string refusal(const std::string& question) {
    ask(question);
    EXPECT_NE(last.status, 0);
    return last.message;
  }

  /// Points on surfaces that the camera sees, and halfway there.
  std::vector<Eigen::Vector3d> seen(double share, int k = 0) const {
    SimulatedKitchen& kitchen = SimulatedKitchen::instance();
    const RgbdCalibration calibration = kitchen.simulation().calibration();
    const RgbdFrame frame = decode_images(kitchen.frame(number(k)), calibration);
    const Utime depth_time = calibration.depth_time(frame.depth_utime);
    const Eigen::Isometry3d T_world_depth = kitchen.simulation().T_world_robot(depth_time) *
                                            calibration.T_robot_camera * calibration.T_colour_depth;
    std::vector<Eigen::Vector3d> points;
    for (int v = frame.depth.rows / 4; v < frame.depth.rows * 3 / 4; v += 7)
      for (int u = frame.depth.cols / 4; u < frame.depth.cols * 3 / 4; u += 7) {
        const double z = 0.001 * frame.depth.at<std::uint16_t>(v, u);
        if (z < 0.5 || z > 4) continue;
        const Eigen::Vector3d point = T_world_depth * (share * z * calibration.depth.ray({u, v}));
        if (share < 1 || kitchen.simulation().distance_to_surface(point) < 0.01) points.push_back(point);
      }
    return points;
  }
  static std::string asked_at(const std::vector<Eigen::Vector3d>& points) {
    json rows = json::array();
    for (const Eigen::Vector3d& p : points) rows.push_back({p.x(), p.y(), p.z()});
    return R"(, "points": )" + rows.dump() + "}";
  }
  static double share_of(const json& states, const std::string& state) {
    return static_cast<double>(std::count(states.begin(), states.end(), state)) /
           static_cast<double>(states.size());
  }

  testing::ScratchFolder scratch_;
  testing::TestBus bus_;
  MapServerNode& node_ = bus_.add<MapServerNode>(
      ConfigNode::parse("{folder: " + scratch_.path().string() +
                        ", store: '', layers: {background: false, rate: 4, surface_rate: 4}}"));
  std::int64_t seq_ = 0;
  map_reply_t last;
};

TEST_F(MapServerQuestions, SpaceIsOccupiedWhereSurfacesAreAndFreeBefore) {
  drive();
  EXPECT_EQ(value_of(node_, "layer_keyframes"), frames / keyframe_every);
  EXPECT_EQ(value_of(node_, "layer_frames"), frames);
  EXPECT_EQ(value_of(node_, "layer_failed"), 0);
  const auto surface = seen(1), halfway = seen(0.5);
  ASSERT_GT(surface.size(), 50U);
  EXPECT_GT(share_of(answer(R"({"ask": "space")" + asked_at(surface))["states"], "occupied"), 0.9);
  EXPECT_GT(share_of(answer(R"({"ask": "space")" + asked_at(halfway))["states"], "free"), 0.9);
  const json below = answer(R"({"ask": "space", "points": [[0, 0, -1]]})");
  EXPECT_EQ(below["states"][0], "unknown");
  EXPECT_THAT(last.content, HasSubstr("application/json; frame=map; map_version="));
}

// Who waits asks again under the same number, in case nobody has heard it.
TEST_F(MapServerQuestions, WhoAsksAgainBeforeTheAnswerIsAnsweredOnce) {
  map_request_t request{};
  request.kind = map_request_t::QUERY;
  request.argument = R"({"ask": "planes"})";
  request.request_id = 5;
  bus_.deliver("MAP_REQUEST", request);
  bus_.deliver("MAP_REQUEST", request);
  map_request_t another = request;
  another.sender = 78;
  bus_.deliver("MAP_REQUEST", another);
  bus_.work();
  EXPECT_EQ(bus_.count("MAP_REPLY"), 2U);
  bus_.deliver("MAP_REQUEST", request);  // that answer was lost
  bus_.work();
  EXPECT_EQ(bus_.count("MAP_REPLY"), 3U);
}

TEST_F(MapServerQuestions, DistancesAreThoseToTheSurfaces) {
  drive();
  const auto points = seen(0.8);
  const json distances = answer(R"({"ask": "distance")" + asked_at(points))["distances"];
  std::vector<double> errors;
  for (std::size_t i = 0; i < points.size(); ++i)
    errors.push_back(std::abs(distances[i].get<double>() -
                              SimulatedKitchen::instance().simulation().distance_to_surface(points[i])));
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.04);  // a cell
}

TEST_F(MapServerQuestions, BodiesAndPathsCollideWithWhatIsThere) {
  drive();
  const Eigen::Vector3d wall = seen(1).front(), air = seen(0.5).front();
  const auto sphere = [](const Eigen::Vector3d& p) { return json{p.x(), p.y(), p.z(), 0.05}; };
  const json collides =
      answer(json{{"ask", "collision"}, {"spheres", {sphere(wall), sphere(air)}}}.dump())["collides"];
  EXPECT_EQ(collides, (json{true, false}));

  const Eigen::Vector3d step = (wall - air) / 10;
  json poses = json::array();
  for (int i = 0; i <= 10; ++i) {
    const Eigen::Vector3d p = air + i * step;
    poses.push_back({p.x(), p.y(), p.z(), 0.0});
  }
  const json robot = {0, 0, 0, 1, 0, 0, 0, 0.1, 0.1, 0.1};
  const json blocked = answer(json{{"ask", "path"}, {"robot", robot}, {"poses", poses}}.dump());
  EXPECT_EQ(blocked["free"], false);
  EXPECT_GT(blocked["first_collision"], 3);
  EXPECT_LE(blocked["first_collision"], 10);
  const json free = answer(json{{"ask", "path"}, {"robot", robot}, {"poses", {poses[0]}}}.dump());
  EXPECT_EQ(free, (json{{"free", true}}));
}

// The mapper's pose is DEGRADED then, since he hides the map.
TEST_F(MapServerQuestions, WhoStepsCloseBeforeTheRobotIsInTheWayAndNotInTheMap) {
  drive();
  const Eigen::Vector3d far_away(30, 0, 0);  // where nothing is known
  std::vector<Eigen::Vector3d> surface = seen(1, frames);
  for (Eigen::Vector3d& p : surface) p += far_away;
  json spheres = json::array();
  for (const Eigen::Vector3d& p : surface) spheres.push_back({p.x(), p.y(), p.z(), 0.05});
  const std::string collision = json{{"ask", "collision"}, {"spheres", spheres}}.dump();
  const auto share_in_the_way = [&] {
    const json collides = answer(collision)["collides"];
    return static_cast<double>(std::count(collides.begin(), collides.end(), true)) /
           static_cast<double>(collides.size());
  };
  ASSERT_GT(surface.size(), 50U);
  ASSERT_EQ(share_in_the_way(), 0);

  const images_t& images = SimulatedKitchen::instance().frame(number(frames));
  bus_.deliver("CAMERA", images);
  const Utime depth_time =
      SimulatedKitchen::instance().simulation().calibration().depth_time(from_message(images).depth.utime);
  pose_estimate_t pose =
      make_pose_estimate(depth_time, T_world_robot(depth_time, far_away), Matrix6d::Identity() * 1e-6);
  pose.seq = frames;
  pose.sender = 3;
  pose.frame = "map";
  pose.status = pose_estimate_t::DEGRADED;
  bus_.deliver("ICP_POSE", pose);
  EXPECT_GT(share_in_the_way(), 0.9);
  EXPECT_EQ(share_of(answer(R"({"ask": "space")" + asked_at(surface))["states"], "unknown"), 1);
}

TEST_F(MapServerQuestions, PlanesObjectsFrontiersAndTheGridAreTold) {
  drive();
  const json planes = answer(R"({"ask": "planes"})")["planes"];
  ASSERT_GT(planes.size(), 0U);
  int walls = 0;
  for (const json& plane : planes) {
    EXPECT_GE(plane["outline"].size(), 3U);
    if (plane["label"] != "wall") continue;
    EXPECT_LT(std::abs(plane["normal"][2].get<double>()), 0.05);
    ++walls;
  }
  EXPECT_GT(walls, 0);
  EXPECT_LE(answer(R"({"ask": "planes", "supporting": true})")["planes"].size(), planes.size());
  EXPECT_EQ(answer(R"({"ask": "planes", "near": [500, 0, 0]})")["planes"].size(), 0U);
  EXPECT_TRUE(answer(R"({"ask": "objects"})")["objects"].is_array());
  EXPECT_GT(answer(R"({"ask": "frontiers"})")["frontiers"].size(), 0U);
  const json grid = answer(R"({"ask": "grid"})");
  std::size_t free = 0;
  for (const auto& row : grid["rows"].get<std::vector<std::string>>())
    free += static_cast<std::size_t>(std::count(row.begin(), row.end(), '.'));
  EXPECT_GT(free, 100U);
}

TEST_F(MapServerQuestions, CloudsAndMeshesAreThoseOfTheRegion) {
  drive();
  EXPECT_THAT(ask(R"({"ask": "cloud", "resolution": 0.01})"), HasSubstr("element vertex"));
  EXPECT_THAT(last.content, HasSubstr("model/ply"));
  EXPECT_THAT(ask(R"({"ask": "cloud", "centre": [500, 0, 0], "radius": 1})"),
              HasSubstr("element vertex 0\n"));
  const std::string mesh = ask(R"({"ask": "mesh"})");
  EXPECT_GT(last.n_tiles, 1);
  EXPECT_GT(mesh.size(), 100'000U);
  const Eigen::Vector3d at = seen(1).front();
  const std::string part =
      ask(json{{"ask", "mesh"}, {"centre", {at.x(), at.y(), at.z()}}, {"radius", 0.3}}.dump());
  EXPECT_LT(part.size(), mesh.size() / 2);
  EXPECT_THAT(part, ::testing::Not(HasSubstr("element vertex 0\n")));
  EXPECT_THAT(ask(R"({"ask": "mesh", "format": "glb"})"), ::testing::StartsWith("glTF"));
}

TEST_F(MapServerQuestions, ACorrectionOfTheGraphMovesAllLayers) {
  const Eigen::Vector3d shift(0.4, 0.3, 0);
  drive(shift);
  const auto surface = seen(1);
  std::vector<Eigen::Vector3d> shifted = surface;
  for (Eigen::Vector3d& p : shifted) p += shift;
  const auto occupied = [&](const std::vector<Eigen::Vector3d>& points) {
    return share_of(answer(R"({"ask": "space")" + asked_at(points))["states"], "occupied");
  };
  EXPECT_GT(occupied(shifted), 0.9);
  EXPECT_LT(occupied(surface), 0.6);
  correct();
  EXPECT_GT(occupied(surface), 0.8);  // from keyframes alone
  const json planes = answer(R"({"ask": "planes"})")["planes"];
  const auto wall =
      std::find_if(planes.begin(), planes.end(), [](const json& p) { return p["label"] == "wall"; });
  ASSERT_NE(wall, planes.end());
  const json& c = (*wall)["centre"];
  EXPECT_LT(SimulatedKitchen::instance().simulation().distance_to_surface(
                Eigen::Vector3d(c[0].get<double>(), c[1].get<double>(), c[2].get<double>())),
            0.02);
}

TEST_F(MapServerQuestions, AnotherMapBeginsAnew) {
  drive();
  const std::string question = R"({"ask": "space")" + asked_at(seen(1));
  EXPECT_GT(share_of(answer(question)["states"], "occupied"), 0.9);
  pose_estimate_t pose = make_pose_estimate(SimulatedKitchen::instance().frame_time(number(frames)),
                                            Eigen::Isometry3d::Identity(), Matrix6d::Identity());
  pose.sender = 3;
  pose.frame = "map-2";
  bus_.deliver("ICP_POSE", pose);
  EXPECT_EQ(share_of(answer(question)["states"], "unknown"), 1);
}

// Its mapper lived on and sends its keyframes again; the camera's images of that time are gone.
TEST_F(MapServerQuestions, ARestartedServerDerivesAnewFromImagesThatItKept) {
  const std::string configuration = "{folder: " + scratch_.path().string() + ", layers: {background: false}}";
  {
    testing::TestBus bus;
    bus.add<MapServerNode>(ConfigNode::parse(configuration));
    drive(bus, {0, 0, 0}, true);
    bus.finish();
  }
  const auto mesh = scratch_.path() / "icp_mesh.ply";
  ASSERT_GT(std::filesystem::file_size(mesh), 100'000U);
  std::filesystem::remove(mesh);
  EXPECT_EQ(MapFile(scratch_.path() / "map.lcmslam").counts(1).images, frames / keyframe_every);
  testing::TestBus bus;
  MapServerNode& node = bus.add<MapServerNode>(ConfigNode::parse(configuration));
  drive(bus, {0, 0, 0}, false);
  EXPECT_EQ(value_of(node, "layer_keyframes"), frames / keyframe_every);
  EXPECT_EQ(value_of(node, "layer_imageless"), 0);
  bus.finish();
  EXPECT_GT(std::filesystem::file_size(mesh), 100'000U);
}

TEST_F(MapServerQuestions, WhatCannotBeAnsweredSaysWhy) {
  EXPECT_THAT(refusal(R"({"ask": "space", "points": [[0, 0, 0]]})"), HasSubstr("no frame"));
  EXPECT_THAT(refusal(R"({"ask": "cloud"})"), HasSubstr("no keyframe"));
  drive();
  EXPECT_THAT(refusal("distance"), HasSubstr("JSON"));
  EXPECT_THAT(refusal(R"({"ask": "weather"})"), HasSubstr("none of distance, collision"));
  EXPECT_THAT(refusal(R"({"ask": "distance"})"), HasSubstr("'points' is missing"));
  EXPECT_THAT(refusal(R"({"ask": "distance", "points": [[0, 0]]})"), HasSubstr("3 numbers"));
  EXPECT_THAT(refusal(R"({"ask": "grid", "colour": 1})"), HasSubstr("'colour' is not asked for"));
  EXPECT_EQ(value_of(node_, "requests_refused"), 6);
  EXPECT_EQ(node_.report().refused, 6) << "STATUS tells it soon";
}

TEST_F(MapServerQuestions, WithoutLayersTheMapItselfIsToldAndItsVersionCounts) {
  testing::TestBus bus;
  bus.add<MapServerNode>(ConfigNode::parse("{folder: " + scratch_.path().string() +
                                           "/bare, store: '', layers: {make: false, background: false}}"));
  drive(bus, {0, 0, 0}, true);
  map_request_t request{};
  request.kind = map_request_t::QUERY;
  for (const char* question : {R"({"ask": "distance", "points": [[0, 0, 0]]})", R"({"ask": "cloud"})"}) {
    ++request.request_id;
    request.argument = question;
    bus.deliver("MAP_REQUEST", request);
    bus.work();
  }
  const auto replies = bus.on<map_reply_t>("MAP_REPLY");
  ASSERT_EQ(replies.size(), 2U);
  EXPECT_THAT(replies[0].message, HasSubstr("map-server.layers.make is false"));
  EXPECT_EQ(replies[1].status, 0) << replies[1].message;
  EXPECT_THAT(replies[1].content, HasSubstr("map_version=" + std::to_string(frames / keyframe_every)));
}

}  // namespace
}  // namespace lcmslam
