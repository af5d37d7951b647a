// Both mappers on the first seconds of the simulated kitchen.

#include <gmock/gmock.h>

#include <set>

#include <lcmslam/associations_t.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/messages/followed_graph.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/particles_t.hpp>
#include "procs/fastslam/fastslam_node.hpp"
#include "procs/icp/icp_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "procs/surf/surf_node.hpp"
#include "tests/support/simulated_kitchen.hpp"

namespace lcmslam {
namespace {

using testing::SimulatedKitchen;
using testing::TestBus;
using testing::value_of;

constexpr int frames = 40;

/// Else following the wheels were good enough for so short a way.
constexpr const char* noisy_wheels = "{noise: {mode: random_walk, sigma: 0.02, seed: 3}}";

/// The graph between camera and map server.
struct Graph {
  TestBus bus;
  OdometryNode& odometry;  // made first
  SurfNode& surf = bus.add<SurfNode>(ConfigNode::parse("{max_features: 400}"));
  FastSlamNode& fastslam = bus.add<FastSlamNode>(ConfigNode::parse("{particles: 40}"));
  IcpNode& icp = bus.add<IcpNode>();

  explicit Graph(const char* odometry_settings = "{}")
      : odometry(bus.add<OdometryNode>(ConfigNode::parse(odometry_settings))) {}

  void play(int count = frames) { SimulatedKitchen::instance().play(bus, count); }
};

const Graph& whole_run() {
  static const auto graph = [] {
    auto made = std::make_unique<Graph>(noisy_wheels);
    made->play();
    made->bus.finish();
    return made;
  }();
  return *graph;
}

double largest_error(const std::vector<pose_estimate_t>& poses) {
  const std::vector<double> errors = SimulatedKitchen::instance().position_errors(poses);
  return *std::max_element(errors.begin(), errors.end());
}

class BothMappers : public ::testing::TestWithParam<const char*> {
 protected:
  std::string channel() const { return GetParam(); }
};

TEST_P(BothMappers, StayWithinThreeCentimetresWhereOdometryErrsByManyMore) {
  const auto poses = whole_run().bus.on<pose_estimate_t>(channel());
  ASSERT_EQ(poses.size(), static_cast<std::size_t>(frames));
  const double error = largest_error(poses);
  RecordProperty("largest_error_mm", static_cast<int>(std::lround(1000 * error)));
  EXPECT_LT(error, 0.03);
  std::vector<pose_estimate_t> by_odometry = poses;
  for (pose_estimate_t& m : by_odometry)
    for (const odometry_t& sample : whole_run().bus.on<odometry_t>("ODOMETRY"))
      if (sample.utime <= m.utime) m.T_map_robot = sample.T_odom_robot;
  EXPECT_GT(largest_error(by_odometry), 0.09);
  // The robot did move, so that standing still would not do.
  const auto& first = poses.front().T_map_robot.trans;
  const auto& last = poses.back().T_map_robot.trans;
  EXPECT_GT(std::hypot(last[0] - first[0], last[1] - first[1]), 0.3);
  for (const pose_estimate_t& m : poses) {
    EXPECT_EQ(m.processing_time, 0);
    EXPECT_NE(m.status, pose_estimate_t::LOST);
  }
}

TEST_P(BothMappers, JumpBackInTimeBeginsANewMapBesideTheOld) {
  Graph graph;
  graph.play(8);
  graph.bus.finish();
  const auto before = graph.bus.on<pose_estimate_t>(channel());
  ASSERT_EQ(before.size(), 8U);
  // The same again, an hour earlier.
  auto& kitchen = SimulatedKitchen::instance();
  const Utime hour = 3'600'000'000;
  for (int k = 0; k < 16; ++k) {
    for (Utime t = kitchen.frame_time(k) - 80'000; t <= kitchen.frame_time(k) + 20'000; t += 20'000) {
      encoders_t encoders = to_message(kitchen.simulation().encoders(t));
      encoders.utime -= hour;
      graph.bus.deliver("ENCODERS", encoders);
    }
    images_t frame = kitchen.frame(k);
    frame.utime -= hour;
    for (image_t& image : frame.images) image.utime -= hour;
    graph.bus.deliver("CAMERA", frame);
  }
  graph.bus.finish();
  EXPECT_EQ(graph.bus.decode_errors(), 0);
  const auto poses = graph.bus.on<pose_estimate_t>(channel());
  ASSERT_GE(poses.size(), 10U);  // each process believes it after half a second of messages
  EXPECT_LT(poses[8].utime, before.front().utime);
  EXPECT_TRUE(from_message(poses[8].T_map_robot, "").isApprox(from_message(before[0].T_map_robot, ""), 0.01));
  for (std::size_t i = 0; i < poses.size(); ++i) EXPECT_EQ(poses[i].frame, i < 8 ? "map" : "map-2");
  EXPECT_EQ(value_of(channel() == "ICP_POSE" ? static_cast<Node&>(graph.icp) : graph.fastslam, "sessions"),
            2);
}

INSTANTIATE_TEST_SUITE_P(Channels, BothMappers, ::testing::Values("FASTSLAM_POSE", "ICP_POSE"));

// POSE = CORRECTION * LOCAL_POSE, and the local pose goes as the robot does.
void expect_pose_in_two_parts(const TestBus& bus, const std::string& mapper) {
  const auto whole = bus.on<pose_estimate_t>(mapper + "_POSE");
  const auto local = bus.on<pose_estimate_t>(mapper + "_LOCAL_POSE");
  const auto correction = bus.on<pose_estimate_t>(mapper + "_CORRECTION");
  ASSERT_EQ(local.size(), whole.size());
  ASSERT_EQ(correction.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const Eigen::Isometry3d T_map_local = from_message(correction[i].T_map_robot, "");
    const Eigen::Isometry3d T_local_robot = from_message(local[i].T_map_robot, "");
    EXPECT_TRUE((T_map_local * T_local_robot).isApprox(from_message(whole[i].T_map_robot, ""), 1e-9));
    EXPECT_EQ(local[i].utime, whole[i].utime);
    EXPECT_EQ(correction[i].utime, whole[i].utime);
    EXPECT_EQ(local[i].frame, "local");
    EXPECT_EQ(local[i].child_frame, "robot");
    EXPECT_EQ(correction[i].frame, "map");
    EXPECT_EQ(correction[i].child_frame, "local");
    if (i == 0) continue;
    const Eigen::Isometry3d step = from_message(local[i - 1].T_map_robot, "").inverse() * T_local_robot;
    EXPECT_LT(step.translation().norm(), 0.12);  // 10 Hz, at most 0.5 m/s
  }
  EXPECT_GT(from_message(local.back().T_map_robot, "").translation().norm(), 0.3);
}

TEST(Mappers, FastSlamTellsItsPoseInTwoParts) {
  const TestBus& bus = whole_run().bus;
  expect_pose_in_two_parts(bus, "FASTSLAM");
  const auto whole = bus.on<pose_estimate_t>("FASTSLAM_POSE");
  const auto local = bus.on<pose_estimate_t>("FASTSLAM_LOCAL_POSE");
  for (std::size_t i = 0; i < whole.size(); ++i)
    EXPECT_LT(local[i].covariance[0], whole[i].covariance[0] + 1e-4);
}

// What the map may err by is in the pose's covariance and not in that of the local pose.
TEST(Mappers, IcpTellsItsPoseInTwoParts) {
  const TestBus& bus = whole_run().bus;
  expect_pose_in_two_parts(bus, "ICP");
  const auto whole = bus.on<pose_estimate_t>("ICP_POSE");
  const auto local = bus.on<pose_estimate_t>("ICP_LOCAL_POSE");
  const auto variance = [](const pose_estimate_t& pose) {
    return pose.covariance[0] + pose.covariance[7] + pose.covariance[14];
  };
  EXPECT_GT(variance(whole.back()), variance(local.back()));
  EXPECT_GT(variance(whole.back()), variance(whole[1]));
}

TEST(Mappers, TwoRunsGiveTheSameBytes) {
  Graph a, b;
  for (Graph* graph : {&a, &b}) {
    graph->play(8);
    graph->bus.finish();
  }
  ASSERT_EQ(a.bus.published().size(), b.bus.published().size());
  for (std::size_t i = 0; i < a.bus.published().size(); ++i)
    ASSERT_EQ(a.bus.published()[i], b.bus.published()[i]) << i << ": " << a.bus.published()[i].channel;
}

TEST(Mappers, EveryMessageOfTheRunIsNumberedAndSound) {
  const TestBus& bus = whole_run().bus;
  EXPECT_EQ(bus.decode_errors(), 0);
  EXPECT_EQ(bus.count("FEATURES"), static_cast<std::size_t>(frames));
  EXPECT_EQ(bus.count("FASTSLAM_PARTICLES"), static_cast<std::size_t>(frames));
  EXPECT_GE(bus.count("ICP_KEYFRAME"), 1U);
  EXPECT_GE(bus.count("FASTSLAM_LANDMARKS"), 10U);
  for (const auto& p : bus.published()) EXPECT_LE(p.bytes.size(), 100'000U) << p.channel;
  for (const particles_t& m : bus.on<particles_t>("FASTSLAM_PARTICLES")) {
    double sum = 0;
    for (const particle_t& p : m.particles) sum += p.weight;
    EXPECT_NEAR(sum, 1, 1e-4);
    EXPECT_LT(m.best, m.n_particles);
  }
  std::int64_t revision = 0;  // changes follow one another
  for (const landmarks_t& m : bus.on<landmarks_t>("FASTSLAM_LANDMARKS")) {
    EXPECT_EQ(m.base_revision, revision);
    revision = m.map_revision;
  }
}

TEST(Mappers, AssociationsNameFeaturesAndLandmarksOfTheRun) {
  const TestBus& bus = whole_run().bus;
  const auto features = bus.on<features_t>("FEATURES");
  const auto associations = bus.on<associations_t>("FASTSLAM_ASSOCIATIONS");
  ASSERT_EQ(associations.size(), features.size());
  std::set<std::int64_t> made;
  std::size_t seen = 0;
  for (std::size_t i = 0; i < associations.size(); ++i) {
    EXPECT_EQ(associations[i].utime, features[i].utime);
    EXPECT_EQ(associations[i].width, features[i].width);
    EXPECT_EQ(associations[i].height, features[i].height);
    for (const association_t& a : associations[i].associations) {
      ASSERT_LT(a.feature, features[i].n_features);
      const feature_t& feature = features[i].features[static_cast<std::size_t>(a.feature)];
      EXPECT_EQ(a.x, feature.x);
      EXPECT_EQ(a.y, feature.y);
      if (a.outcome == association_t::CREATED) {
        EXPECT_TRUE(made.insert(a.landmark).second) << "an id is used once";
      } else {
        EXPECT_EQ(made.count(a.landmark), 1U) << "seen before it was made";
        ++seen;
      }
    }
  }
  EXPECT_GT(made.size(), 50U);
  EXPECT_GT(seen, made.size());
  for (const landmarks_t& m : bus.on<landmarks_t>("FASTSLAM_LANDMARKS"))
    for (const landmark_t& landmark : m.landmarks) EXPECT_EQ(made.count(landmark.id), 1U);
}

TEST(Mappers, FramesWithoutOdometryGoOnAndAreCounted) {
  TestBus bus;
  bus.add<SurfNode>();
  const FastSlamNode& fastslam = bus.add<FastSlamNode>(ConfigNode::parse("{particles: 20}"));
  const IcpNode& icp = bus.add<IcpNode>();
  SimulatedKitchen::instance().play(bus, 5);  // nobody turns ENCODERS into ODOMETRY
  bus.finish();
  EXPECT_EQ(value_of(fastslam, "steps"), 5);
  EXPECT_EQ(value_of(fastslam, "without_odometry"), 5);
  EXPECT_EQ(value_of(icp, "steps"), 5);
  EXPECT_EQ(value_of(icp, "without_odometry"), 5);
}

TEST(Mappers, TheGraphIsToldByItsChanges) {
  const auto graphs = whole_run().bus.on<graph_t>("ICP_GRAPH");
  ASSERT_GE(graphs.size(), 3U);
  FollowedGraph followed;
  std::size_t told = 0;
  for (const graph_t& m : graphs) {
    const bool first_or_last = &m == &graphs.front() || &m == &graphs.back();
    EXPECT_EQ(m.change, first_or_last ? 0 : 1);
    if (!first_or_last) told += m.nodes.size();
    followed.apply(m);
    EXPECT_TRUE(followed.complete());
    if (&m != &graphs[graphs.size() - 2]) continue;
    EXPECT_EQ(followed.nodes().size(), graphs.back().nodes.size());
    EXPECT_GE(followed.edges().size(), followed.nodes().size() - 1);
  }
  EXPECT_LT(2 * told, graphs.size() * graphs.back().nodes.size());
  std::set<std::int32_t> keyframes;
  for (const keyframe_t& tile : whole_run().bus.on<keyframe_t>("ICP_KEYFRAME")) keyframes.insert(tile.id);
  for (const std::int32_t id : keyframes) EXPECT_EQ(followed.nodes().count(id), 1U) << id;
}

// Over a real bus tiles are paced: the graph may move keyframes that still wait.
TEST(Mappers, KeyframesThatWaitedGoOutWhereTheGraphHasMovedThem) {
  Graph graph(noisy_wheels);
  graph.play();
  const std::size_t tiles_before = graph.bus.count("ICP_KEYFRAME");
  graph.bus.command("resend");
  const auto poses_of = [](const graph_t& whole) {
    std::map<std::int32_t, Eigen::Isometry3d> poses;
    for (const graph_node_t& node : whole.nodes)
      poses[node.keyframe] = from_message(node.T_map_camera, "T_map_camera");
    return poses;
  };
  const auto before = poses_of(graph.bus.on<graph_t>("ICP_GRAPH").back());
  graph.bus.finish();
  const graph_t last = graph.bus.on<graph_t>("ICP_GRAPH").back();
  ASSERT_EQ(last.change, 0);
  const auto after = poses_of(last);
  const auto tiles = graph.bus.on<keyframe_t>("ICP_KEYFRAME");
  ASSERT_GT(tiles.size(), tiles_before);
  double moved = 0;
  for (std::size_t i = tiles_before; i < tiles.size(); ++i) {
    const Eigen::Isometry3d T = from_message(tiles[i].T_map_camera, "T_map_camera");
    EXPECT_LT(distance_between(T, after.at(tiles[i].id)), 1e-9) << tiles[i].id;
    moved = std::max(moved, distance_between(after.at(tiles[i].id), before.at(tiles[i].id)));
  }
  EXPECT_GT(moved, 1e-4) << "nothing was moved, nothing is shown";
}

TEST(Mappers, ResendGivesTheWholeMap) {
  Graph graph;
  graph.play();
  graph.bus.finish();
  const std::size_t landmarks_before = graph.bus.count("FASTSLAM_LANDMARKS");
  const std::size_t tiles = graph.bus.count("ICP_KEYFRAME");
  ASSERT_GE(tiles, 1U);
  const std::size_t graphs_before = graph.bus.count("ICP_GRAPH");
  graph.bus.command("resend");
  graph.bus.finish();
  EXPECT_EQ(graph.bus.count("ICP_KEYFRAME"), 2 * tiles);
  const auto keyframes = graph.bus.on<keyframe_t>("ICP_KEYFRAME");
  std::map<std::pair<int, int>, keyframe_t> newest;
  for (std::size_t i = 0; i < tiles; ++i) newest[{keyframes[i].id, keyframes[i].tile}] = keyframes[i];
  const int last = newest.rbegin()->first.first;  // still grows
  ASSERT_GE(last, 1) << "nothing is shown";
  for (std::size_t i = tiles; i < keyframes.size(); ++i) {
    const keyframe_t& before = newest.at({keyframes[i].id, keyframes[i].tile});
    if (keyframes[i].id == last) continue;
    EXPECT_EQ(keyframes[i].map_revision, before.map_revision) << "the same cloud, and known again";
    EXPECT_EQ(keyframes[i].position, before.position);
  }
  const auto graphs = graph.bus.on<graph_t>("ICP_GRAPH");
  ASSERT_EQ(graphs.size(), graphs_before + 2);  // and once more at the end
  EXPECT_EQ(graphs[graphs_before].change, 0);
  EXPECT_FALSE(graphs[graphs_before].nodes.empty());
  const auto all = graph.bus.on<landmarks_t>("FASTSLAM_LANDMARKS");
  ASSERT_GT(all.size(), landmarks_before);
  EXPECT_EQ(all[landmarks_before].base_revision, 0);
  EXPECT_EQ(all[landmarks_before].map_revision, all[landmarks_before - 1].map_revision);
  std::size_t landmarks = 0;
  for (std::size_t i = landmarks_before; i < all.size(); ++i) landmarks += all[i].landmarks.size();
  EXPECT_GT(landmarks, 30U);
}

}  // namespace
}  // namespace lcmslam
