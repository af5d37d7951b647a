// By how much a graph's measurements err, told by how they contradict each other: against errors that were
// drawn larger or smaller than they are said to be.

#include <lcmslam/pose_graph/error_factors.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/pose_graph/keyframe_graph.hpp>
#include <lcmslam/pose_graph/pose_covariance.hpp>
#include "tests/support/cloud_scenes.hpp"
#include "tests/unit/dense_mapper/gallery.hpp"

namespace lcmslam {
namespace {

constexpr double stated_sigma_t = 0.01, stated_sigma_r = 0.005;

Vector6d sigmas() {
  Vector6d s;
  s << Eigen::Vector3d::Constant(stated_sigma_t), Eigen::Vector3d::Constant(stated_sigma_r);
  return s;
}

PoseGraphSettings plain_settings() {
  PoseGraphSettings settings;
  settings.edge_error = settings.ground_error = 1;
  settings.motion_scale = settings.turn_scale = settings.curvature = 0;
  settings.kernel_width = settings.max_error = 1e6;
  settings.stated_measurements = 0.1;
  return settings;
}

void add(PoseGraph& graph, int from, int to, const Eigen::Isometry3d& T_from_to, double times,
         Random& random) {
  Vector6d noise;
  for (int i = 0; i < 6; ++i) noise(i) = times * sigmas()(i) * random.normal();
  const Matrix6d stated = sigmas().cwiseAbs2().asDiagonal();
  graph.edges.push_back({from, to, EdgeKind::registration, {T_from_to * se3_exp(noise), stated}, 0});
}

/// Each pose tied to the three before it, by edges that err `times` as much as they say.
PoseGraph graph_erring(double times, int poses, int ties, std::uint64_t seed) {
  PoseGraph graph;
  Random random(seed);
  const Eigen::Isometry3d step = se3_exp(twist(0.3, 0, 0.02, 0, 0.01, 0.2));
  for (int i = 0; i < poses; ++i) {
    graph.poses.push_back(i == 0 ? Eigen::Isometry3d::Identity() : graph.poses.back() * step);
    Eigen::Isometry3d way = Eigen::Isometry3d::Identity();
    for (int k = 1; k <= std::min(i, ties); ++k) {
      way = step * way;
      add(graph, i - k, i, way, times, random);
    }
  }
  optimise(graph, plain_settings());
  return graph;
}

TEST(ErrorFactors, TellWhatEdgesErrBy) {
  for (const double times : {0.4, 1.0, 2.5}) {
    double squares = 0;
    constexpr int seeds = 12;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      const ErrorFactors factors = error_factors(graph_erring(times, 20, 3, seed), plain_settings());
      squares += factors.edges * factors.edges / seeds;
      EXPECT_EQ(factors.ground, 1);
    }
    // 12 times 210 redundant rows: 3 % of the variance.
    EXPECT_NEAR(std::sqrt(squares), times, 0.06 * times) << times;
  }
}

// Poses that stand still where they are known to be, on a floor that waves.
TEST(ErrorFactors, TellHowFlatTheGroundIs) {
  constexpr double waves = 0.25;
  PoseGraph graph = graph_erring(0, 1, 0, 1);
  graph.ground = GroundConstraint{se3_exp(twist(0.1, 0.2, -0.3, 0.4, 0.1, 0.2)), {}, {}};
  const Eigen::Isometry3d T_robot_camera = graph.ground->T_camera_robot.inverse();
  Random random(3);
  std::vector<Eigen::Isometry3d> robot;
  for (int i = 0; i < 100; ++i) {
    const bool up_a_ramp = i >= 60;
    const Eigen::Vector3d s(graph.ground->plane.height, graph.ground->plane.tilt, graph.ground->plane.tilt);
    const double times = up_a_ramp ? 50 : waves;
    Vector6d off = Vector6d::Zero();
    for (int k = 0; k < 3; ++k) off(2 + k) = times * s(k) * random.normal();
    robot.push_back(planar_pose(0.3 * i, 0, 0.1 * i) * se3_exp(off));
    graph.ground->floors.push_back(up_a_ramp ? Floor::free : Floor::plane);
  }
  graph.poses.clear();
  for (const Eigen::Isometry3d& T : robot) graph.poses.push_back(T * T_robot_camera);
  for (int i = 1; i < 100; ++i) {
    const auto to = static_cast<std::size_t>(i);
    graph.edges.push_back({i - 1,
                           i,
                           EdgeKind::registration,
                           {graph.poses[to - 1].inverse() * graph.poses[to], 1e-12 * Matrix6d::Identity()},
                           0});
  }
  const ErrorFactors factors = error_factors(graph, plain_settings());
  EXPECT_NEAR(factors.ground, waves, 0.15 * waves);  // 59 nodes of three rows: 5 % of the deviation
}

// A chain checks nothing, and what is said of it stays.
TEST(ErrorFactors, StayWhereNothingContradicts) {
  EXPECT_NEAR(error_factors(graph_erring(3, 20, 1, 1), plain_settings()).edges, 1, 1e-3);
  PoseGraph untied = graph_erring(1, 5, 2, 1);
  untied.poses.push_back(Eigen::Isometry3d::Identity());
  EXPECT_EQ(error_factors(untied, plain_settings()).edges, 1);
}

// Along a bare floor frames say where they are by nothing: nothing checks that either.
TEST(ErrorFactors, StayWhereAWayIsNotMeasured) {
  Matrix6d along = sigmas().cwiseAbs2().asDiagonal();
  along(0, 0) = 900;
  PoseGraph floor;
  floor.poses.resize(60, Eigen::Isometry3d::Identity());
  for (int i = 1; i < 60; ++i)
    floor.edges.push_back({i - 1, i, EdgeKind::odometry, {Eigen::Isometry3d::Identity(), along}, 0});
  EXPECT_NEAR(error_factors(floor, plain_settings()).edges, 1, 1e-3);
}

// Few measurements that contradict each other by chance do not make a graph sure of itself.
TEST(ErrorFactors, CountWhatTheSettingsSay) {
  PoseGraphSettings settings = plain_settings();
  settings.stated_measurements = 1e4;
  EXPECT_NEAR(error_factors(graph_erring(3, 20, 3, 1), settings).edges, 1, 0.02);
}

TEST(ErrorFactors, ScaleWhatPosesAreToldToErrBy) {
  const PoseGraph graph = graph_erring(1, 12, 3, 1);
  const Matrix6d once = pose_errors(graph, plain_settings()).back().covariance();
  const Matrix6d twice = pose_errors(graph, plain_settings(), {2, 1}).back().covariance();
  EXPECT_LT((twice - 4 * once).norm(), 1e-9 * once.norm());
}

// A way that odometry alone knows: registrations that agree do not make it surer, nor does it count among
// them.
TEST(ErrorFactors, AreNothingToOdometry) {
  PoseGraph graph = graph_erring(0.4, 20, 3, 1);
  const double edges = error_factors(graph, plain_settings()).edges;
  GraphEdge led;
  led.from = 19;
  led.to = 20;
  led.expected_share = 0.5;
  led.T_from_to.covariance = 0.04 / (led.expected_share * led.expected_share) * Matrix6d::Identity();
  graph.poses.push_back(graph.poses.back());
  graph.edges.push_back(led);
  GraphEdge astray = led;  // by ten of its sigmas
  astray.from = 0;
  astray.T_from_to.T = graph.poses.front().inverse() * graph.poses.back() * Eigen::Translation3d(2, 0, 0);
  graph.edges.push_back(astray);
  PoseGraphSettings settings = plain_settings();
  EXPECT_NEAR(error_factors(graph, settings).edges, edges, 1e-3);
  settings.edge_error = led.expected_share;
  for (const double factor : {0.3, 1.0, 3.0}) {
    const Matrix6d told = edge_error(led, settings, {factor, 1});
    EXPECT_NEAR(told(0, 0), 0.04, 1e-12) << factor;
  }
}

// What an edge does not measure is no measurement that agrees.
TEST(ErrorFactors, CountWhatIsMeasuredOnly) {
  PoseGraph graph = graph_erring(2, 20, 3, 1);
  const double edges = error_factors(graph, plain_settings()).edges;
  for (int i = 0; i < 19; ++i) {
    GraphEdge blind{i, i + 1, EdgeKind::registration, {}, 0};
    const auto from = static_cast<std::size_t>(i);
    blind.T_from_to = {graph.poses[from].inverse() * graph.poses[from + 1], 900 * Matrix6d::Identity()};
    graph.edges.push_back(blind);
  }
  EXPECT_NEAR(error_factors(graph, plain_settings()).edges, edges, 1e-3);
}

/// Back and forth along a gallery, with keyframes on the way there; the robot's frame is the camera's.
struct Drive {
  explicit Drive(const KeyframeGraphSettings& graph_settings = {}) : settings(graph_settings) {}

  Gallery gallery = Gallery(4);
  KeyframeGraphSettings settings;
  KeyframeGraph graph{settings};
  Utime now = 1'000'000;

  void add(int i) {
    const Eigen::Isometry3d T(Eigen::Translation3d(i <= 8 ? 0.4 * i : 0.4 * (16 - i), 0, 0));
    graph.add(now, T, 1e-6 * Matrix6d::Identity(), gallery.seen_from(T), i <= 8);
    now += 1'000'000;
  }
  Matrix6d covariance() const { return graph.nodes().back().error.covariance(); }
};

TEST(ErrorFactors, OfANewPoseAreThoseOfTheLastWork) {
  KeyframeGraphSettings settings;
  settings.optimiser.edge_error = 0.2;
  Drive drive(settings);
  for (int i = 0; i <= 16; ++i) drive.add(i);
  EXPECT_EQ(drive.graph.error_factors().edges, 1);
  if (const auto correction = drive.graph.finish()) drive.graph.apply(*correction);
  const double factor = drive.graph.error_factors().edges;
  EXPECT_LT(factor, 0.7);  // the gallery's edges agree with each other far better than they say
  const Matrix6d before = drive.covariance();
  drive.add(16);  // stands still
  const Matrix6d edge = drive.graph.edges().back().T_from_to.covariance;
  const double scale = std::pow(factor * drive.settings.optimiser.edge_error, 2);
  EXPECT_LT((drive.covariance() - before - scale * edge).norm(), 1e-3 * scale * edge.norm());
}

// Between two works as in them: the robot stands on its floor.
TEST(ErrorFactors, ANewPoseStandsOnTheGround) {
  constexpr double ground = 0.2;
  KeyframeGraphSettings settings;
  settings.optimiser.ground_error = ground;
  settings.optimiser.edge_error = 0.2;
  Drive drive(settings);
  const GroundSettings plane;
  drive.graph.set_ground(GroundConstraint{Eigen::Isometry3d::Identity(), plane, {}});
  for (int i = 0; i <= 5; ++i) drive.add(i);
  const Vector6d s = drive.covariance().diagonal().cwiseSqrt();
  EXPECT_LT(s(2), ground * plane.height);
  EXPECT_LT(s(3), ground * plane.tilt);
  EXPECT_LT(s(4), ground * plane.tilt);
  EXPECT_GT(s(0), 2 * ground * plane.height);  // which says nothing of the way
}

}  // namespace
}  // namespace lcmslam
