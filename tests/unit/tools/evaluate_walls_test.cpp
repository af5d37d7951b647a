// lcmslam evaluate --walls: the dense map that a log's messages make.

#include <cmath>

#include <lcmslam/graph_t.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/messages/graph_teller.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include "tests/unit/tools/evaluate_fixture.hpp"
#include "tools/evaluate/dense_map_log.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using testing::MessageLog;

constexpr Utime second = 1'000'000;

/// A robot between two walls 4 m apart, whose map lies elsewhere.
class EvaluateWalls : public testing::Evaluate {
 protected:
  EvaluateWalls() {
    scratch_.write(
        "room.yaml",
        "name: room\n"
        "materials: [{name: wall, colour: [128, 128, 128], infrared: 0.6}]\n"
        "rooms: [{from: [-2, -6], to: [2, 6], height: 3, walls: wall, floor: wall, ceiling: wall}]\n"
        "path: [0, 0, 1, 0]\nambient: 1\n");
  }

  /// The wall at x = 2, `before` (m) its true place, published by a mapper as keyframe `id`.
  std::vector<keyframe_t> wall(std::int64_t sender, std::int32_t id, double seconds, double before) const {
    DenseKeyframe keyframe;
    keyframe.id = id;
    keyframe.utime = static_cast<Utime>(seconds * second);
    keyframe.T_world_camera = T_map_world_ * T_world_camera_;
    const Eigen::Isometry3d T_camera_world = T_world_camera_.inverse();
    for (int i = -49; i <= 49; ++i)
      for (int j = -49; j <= 49; ++j) {
        keyframe.cloud.points.push_back(
            (T_camera_world * Eigen::Vector3d(2 - before, 0.02 * i, 1.5 + 0.02 * j)).cast<float>());
        keyframe.cloud.normals.push_back((T_camera_world.linear() * Eigen::Vector3d(-1, 0, 0)).cast<float>());
        keyframe.cloud.colours.emplace_back(1, 2, 3);
      }
    auto tiles = make_keyframe_tiles(keyframe, Eigen::Isometry3d::Identity(), id + 1);
    for (keyframe_t& tile : tiles) tile.seq = 0, tile.sender = sender;
    return tiles;
  }

  graph_t graph(std::int64_t sender, const std::vector<std::int32_t>& ids,
                const Eigen::Isometry3d& T_right_wrong = Eigen::Isometry3d::Identity()) const {
    graph_t m{};
    m.utime = 40 * second;
    m.seq = m.map_revision = m.n_edges = 0;
    m.sender = sender;
    m.frame = "map";
    for (const std::int32_t id : ids) {
      graph_node_t node;
      node.keyframe = id;
      node.keyframe_utime = 0;
      node.T_map_camera = to_message(T_map_world_ * T_right_wrong * T_world_camera_);
      m.nodes.push_back(node);
    }
    m.n_nodes = static_cast<std::int32_t>(ids.size());
    return m;
  }

  void write(MessageLog& log, const std::vector<keyframe_t>& tiles) const {
    for (const keyframe_t& tile : tiles) log.write("ICP_KEYFRAME", tile);
  }
  void write_poses(MessageLog& log) const {
    for (const StampedPose& pose : path_) {
      log.write("GROUND_TRUTH", testing::truth_message(pose, "robot"));
      log.write("ICP_POSE", testing::estimate_message({pose.utime, T_map_world_ * pose.T_world_body}, 6));
    }
  }

  const Eigen::Isometry3d T_map_world_ = Eigen::Translation3d(3, -1, 0.2) * planar_pose(0, 0, 0.7);
  const Eigen::Isometry3d T_world_camera_ = Eigen::Translation3d(0, 0, 1.5) * optical_axes();
  static constexpr std::size_t wall_points_ = 99 * 99;
};

TEST_F(EvaluateWalls, FirstAndLastVisitOfTheNewestMapAreCompared) {
  const Eigen::Isometry3d aside(Eigen::Translation3d(-0.05, 0, 0));
  {
    MessageLog log(path("run.lcmlog"));
    write_poses(log);
    write(log, wall(5, 0, 1, 0.1));  // an older mapper's
    log.write("ICP_GRAPH", graph(5, {0}));
    write(log, wall(6, 0, 1, 0.01));
    write(log, wall(6, 1, 2, 0.13));  // thinned out later, or of a map that was given up,
    write(log, wall(6, 9, 2, 0.13));
    GraphTeller teller;  // of what changed
    log.write("ICP_GRAPH", teller.tell(graph(6, {0, 1, 9}), false));
    log.write("ICP_GRAPH", teller.tell(graph(6, {0}), false));
    for (const keyframe_t& tile : wall(6, 2, 31, 0.04)) log.write_in_pieces("ICP_KEYFRAME", tile);
    log.write("ICP_GRAPH", teller.tell(graph(6, {0, 2}, aside), false));  // put right by the last one
    write(log, wall(5, 0, 60, 0.12));
    log.write("ICP_GRAPH", graph(5, {0}));
    log.write("ICP_GRAPH", teller.tell(graph(6, {0, 2, 9}), false));  // the new map's 9 never came
    const auto tile = wall(6, 3, 60, 0.1).front();
    auto bytes = encode_message(tile);
    bytes.pop_back();
    log.write_bytes("ICP_KEYFRAME", tile.utime, bytes);
    auto wrong = tile;
    wrong.tile = wrong.n_tiles;
    log.write("ICP_KEYFRAME", wrong);
    auto broken = graph(6, {0});
    broken.nodes[0].T_map_camera.trans[0] = std::nan("");
    log.write("ICP_GRAPH", broken);
  }
  ASSERT_EQ(run({path("run.lcmlog"), "--walls", path("room.yaml"), "--json", path("out.json")}), 0)
      << output_;
  EXPECT_THAT(output_, HasSubstr("3 messages of the map could not be decoded or were refused"));
  const auto walls = json("out.json").at("walls");
  EXPECT_EQ(walls.at("placed_by"), "ICP_POSE");
  EXPECT_EQ(walls.at("points"), 2 * wall_points_);
  EXPECT_EQ(walls.at("refused_messages"), 3);
  EXPECT_GE(walls.at("revisited_patches"), 8 * 8);
  EXPECT_EQ(walls.at("revisited_patches"), walls.at("patches"));
  for (const char* figure : {"offset_median_m", "offset_p95_m", "offset_max_m", "thickness_median_m"})
    EXPECT_NEAR(walls.at(figure).get<double>(), 0.03, 1e-3) << figure;
  EXPECT_FALSE(json("out.json").contains("map"));
}

TEST_F(EvaluateWalls, AWallThatIsDoubledFarOffIsSeen) {
  {
    MessageLog log(path("run.lcmlog"));
    write_poses(log);
    write(log, wall(6, 0, 1, 0));
    write(log, wall(6, 1, 60, 0.2));
    log.write("ICP_GRAPH", graph(6, {0, 1}));
  }
  ASSERT_EQ(run({path("run.lcmlog"), "--walls", path("room.yaml"), "--json", path("out.json")}), 0)
      << output_;
  const auto walls = json("out.json").at("walls");
  EXPECT_EQ(walls.at("revisited_patches"), 0) << "none of the second wall's points is of a patch";
  EXPECT_EQ(walls.at("beyond_share"), 0.5);
  EXPECT_THAT(output_, HasSubstr("50.00 % of 19602 points are more than 0.15 m from any surface"));
}

TEST_F(EvaluateWalls, ALogWithoutAMapSaysSo) {
  {
    MessageLog log(path("run.lcmlog"));
    write_poses(log);
    log.write("ICP_KEYFRAME", wall(6, 0, 1, 0).front());  // one tile of several
  }
  EXPECT_EQ(run({path("run.lcmlog"), "--walls", path("room.yaml")}), -1);
  EXPECT_THAT(output_, HasSubstr("no ICP_KEYFRAME"));
}

}  // namespace
}  // namespace lcmslam
