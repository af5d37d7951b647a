#include <lcmslam/pose_graph/pose_graph.hpp>

#include <gmock/gmock.h>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/pose_graph/error_factors.hpp>
#include <lcmslam/pose_graph/loop_admission.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

constexpr double sigma_t = 0.01, sigma_r = 0.005;

Matrix6d covariance(double t = sigma_t, double r = sigma_r) {
  Matrix6d m = Matrix6d::Zero();
  m.diagonal().head<3>().setConstant(t * t);
  m.diagonal().tail<3>().setConstant(r * r);
  return m;
}

Vector6d noise(Random& random, double t = sigma_t, double r = sigma_r) {
  Vector6d v;
  for (int i = 0; i < 6; ++i) v(i) = (i < 3 ? t : r) * random.normal();
  return v;
}

/// A walk twice around a square of 10 m, by noisy odometry; the second round sees the first again.
struct Walk {
  std::vector<Eigen::Isometry3d> truth;
  PoseGraph graph;

  explicit Walk(std::uint64_t seed, int count = 80) {
    Random random(seed);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    for (int i = 0; i < count; ++i) {
      if (i > 0) {
        const Eigen::Isometry3d step = se3_exp(twist(1, 0, 0, 0, 0, i % 10 == 0 ? M_PI / 2 : 0));
        T = T * step;
        GraphEdge edge;
        edge.from = i - 1;
        edge.to = i;
        edge.T_from_to = {step * se3_exp(noise(random)), covariance()};
        graph.edges.push_back(edge);
      }
      truth.push_back(T);
      graph.poses.push_back(i == 0 ? T : graph.poses.back() * graph.edges.back().T_from_to.T);
    }
  }

  GraphEdge loop(int from, int to, Random& random) const {
    const Eigen::Isometry3d T =
        truth[static_cast<std::size_t>(from)].inverse() * truth[static_cast<std::size_t>(to)];
    return {
        from, to, EdgeKind::loop, {T * se3_exp(noise(random, 0.005, 0.003)), covariance(0.005, 0.003)}, 0};
  }

  double rmse() const {
    double sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i)
      sum += (truth[i].translation() - graph.poses[i].translation()).squaredNorm();
    return std::sqrt(sum / static_cast<double>(truth.size()));
  }
};

TEST(PoseGraph, KnownLoopsBringTheDriftBack) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Walk walk(seed);
    Random random(seed + 100);
    const double before = walk.rmse();
    for (int i = 40; i < 80; i += 3) walk.graph.edges.push_back(walk.loop(i - 40, i, random));
    EXPECT_EQ(optimise(walk.graph, {}), 0) << "seed " << seed;
    EXPECT_LT(walk.rmse(), 0.6 * before) << "seed " << seed;
    EXPECT_TRUE(walk.graph.poses.front().isApprox(walk.truth.front(), 1e-12)) << "seed " << seed;
    double squares = 0;  // errors over sigma are of the size that the sigmas say
    for (const GraphEdge& e : walk.graph.edges) squares += e.error * e.error;
    EXPECT_LT(squares / static_cast<double>(6 * walk.graph.edges.size()), 1.3) << "seed " << seed;
  }
}

TEST(PoseGraph, ExactMeasurementsGiveTheExactPoses) {
  Walk walk(1);
  for (GraphEdge& e : walk.graph.edges)
    e.T_from_to.T =
        walk.truth[static_cast<std::size_t>(e.from)].inverse() * walk.truth[static_cast<std::size_t>(e.to)];
  ASSERT_GT(walk.rmse(), 0.05);
  optimise(walk.graph, {});
  EXPECT_LT(walk.rmse(), 1e-5);
}

TEST(PoseGraph, FalseLoopsAreRefusedAndTrueOnesStay) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Walk walk(seed);
    Random random(seed + 100);
    for (int i = 40; i < 80; i += 3) walk.graph.edges.push_back(walk.loop(i - 40, i, random));
    const std::size_t sound = walk.graph.edges.size();
    for (int k = 0; k < 3; ++k) {  // "this is where I was", three times wrong, each in its own way
      GraphEdge lie = walk.loop(5 * k, 45 + 7 * k, random);
      lie.T_from_to.T = lie.T_from_to.T * se3_exp(twist(1 + k, -2, 0, 0, 0.3, -0.5 * k));
      walk.graph.edges.push_back(lie);
    }
    EXPECT_EQ(optimise(walk.graph, {}), 3) << "seed " << seed;
    EXPECT_EQ(walk.graph.edges.size(), sound) << "seed " << seed;
    EXPECT_LT(walk.rmse(), 0.25) << "seed " << seed;
  }
}

TEST(PoseGraph, ALoopWithinTheGraphsUncertaintyIsBelievedAtOnce) {
  Walk walk(3);
  Random random(7);
  std::vector<GraphEdge> waiting = {walk.loop(0, 40, random)};
  EXPECT_EQ(admit(waiting, walk.graph, {}), 1);
  EXPECT_TRUE(waiting.empty());
}

TEST(PoseGraph, AnUnlikelyLoopWaitsForOthersThatAgreeWithIt) {
  Walk walk(3);
  Random random(7);
  // Drift that odometry does not admit to: a slip of half a metre.
  walk.graph.edges[20].T_from_to.T =
      walk.graph.edges[20].T_from_to.T * se3_exp(twist(0.5, 0.5, 0, 0, 0, 0.2));
  for (std::size_t i = 21; i < walk.graph.poses.size(); ++i)
    walk.graph.poses[i] = walk.graph.poses[i - 1] * walk.graph.edges[i - 1].T_from_to.T;
  std::vector<GraphEdge> waiting = {walk.loop(0, 40, random), walk.loop(2, 42, random)};
  EXPECT_EQ(admit(waiting, walk.graph, {}), 0);
  ASSERT_EQ(waiting.size(), 2U);
  GraphEdge lie = walk.loop(3, 43, random);
  lie.T_from_to.T = lie.T_from_to.T * se3_exp(twist(2, 1, 0, 0, 0, 0.5));
  waiting.push_back(lie);
  EXPECT_EQ(admit(waiting, walk.graph, {}), 0);  // two that agree and one that lies
  waiting.push_back(walk.loop(4, 44, random));
  EXPECT_EQ(admit(waiting, walk.graph, {}), 3);
  ASSERT_EQ(waiting.size(), 1U);
  EXPECT_EQ(waiting.front().to, 43);
}

// The doors of a corridor look alike: what takes each for its neighbour agrees with itself, and is believed.
// Until the graph is optimised, which refuses it, its poses would be told to err by metres.
TEST(PoseGraph, WhatIsBelievedIsWeighedAtOnce) {
  Walk walk(3);
  Random random(7);
  PoseGraphSettings settings;
  settings.edge_error = 0.2;
  for (int i = 41; i < 80; i += 3) walk.graph.edges.push_back(walk.loop(i - 40, i, random));
  optimise(walk.graph, {});
  const std::size_t sound = walk.graph.edges.size();
  std::vector<GraphEdge> waiting;
  const Eigen::Isometry3d to_the_next_door(Eigen::Translation3d(0, 3, 0));
  for (const int i : {0, 2, 4}) {
    waiting.push_back(walk.loop(i, 40 + i, random));
    const Eigen::Isometry3d& T_to = walk.truth[static_cast<std::size_t>(40 + i)];
    Eigen::Isometry3d& T = waiting.back().T_from_to.T;
    T = T * T_to.inverse() * to_the_next_door * T_to;
  }
  PoseGraph unweighed = walk.graph;
  std::vector<GraphEdge> others = waiting;
  EXPECT_EQ(admit(others, unweighed, {}), 3);
  EXPECT_GT(error_factors(unweighed, settings).edges, 10);
  EXPECT_TRUE(close_circles(waiting, walk.graph, {}));
  EXPECT_TRUE(waiting.empty());
  EXPECT_EQ(walk.graph.edges.size(), sound);
  EXPECT_LT(error_factors(walk.graph, settings).edges, 5);
  EXPECT_FALSE(close_circles(waiting, walk.graph, {}));  // there is nothing new
}

TEST(PoseGraph, TheGroundHoldsHeightAndTilt) {
  Walk walk(5);
  walk.graph.ground = GroundConstraint();
  optimise(walk.graph, {});
  for (const Eigen::Isometry3d& T : walk.graph.poses) {
    EXPECT_LT(std::abs(T.translation().z()), 0.03);
    EXPECT_LT((T.linear().col(2) - Eigen::Vector3d::UnitZ()).norm(), 0.02);
  }
}

TEST(PoseGraph, TheGroundHoldsWhatEachNodesFloorTells) {
  Walk free(5), held(5);
  held.graph.ground = GroundConstraint();
  held.graph.ground->floors.assign(held.graph.poses.size(), Floor::free);
  optimise(free.graph, {});
  optimise(held.graph, {});
  for (std::size_t i = 0; i < free.graph.poses.size(); ++i)
    EXPECT_TRUE(held.graph.poses[i].isApprox(free.graph.poses[i], 1e-3)) << i;

  Walk level(5);  // and 20 cm higher than its measurements say
  for (std::size_t i = 1; i < level.graph.poses.size(); ++i) level.graph.poses[i].translation().z() += 0.2;
  level.graph.edges.front().T_from_to.T.translation().z() += 0.2;
  level.graph.ground = GroundConstraint();
  level.graph.ground->floors.assign(level.graph.poses.size(), Floor::level);
  optimise(level.graph, {});
  EXPECT_GT(level.graph.poses.back().translation().z(), 0.1);
  for (const Eigen::Isometry3d& T : level.graph.poses)
    EXPECT_LT((T.linear().col(2) - Eigen::Vector3d::UnitZ()).norm(), 0.02);
}

TEST(PoseGraph, ExpectsWithTheCovarianceOfTheSurestWay) {
  Walk walk(2, 30);
  const auto far = SurestChains(walk.graph, 0).to(29);
  ASSERT_TRUE(far);
  EXPECT_TRUE(far->T.isApprox(walk.graph.poses[0].inverse() * walk.graph.poses[29], 1e-9));
  Random random(1);
  GraphEdge unsure = walk.loop(0, 29, random);  // one step, but less is known of it than of all the others
  unsure.T_from_to.covariance = covariance(5, 2);
  walk.graph.edges.push_back(unsure);
  EXPECT_EQ(SurestChains(walk.graph, 0).to(29)->covariance, far->covariance);
  walk.graph.edges.push_back(walk.loop(0, 29, random));
  const auto near = SurestChains(walk.graph, 0).to(29);
  EXPECT_LT(near->covariance.trace(), 0.1 * far->covariance.trace());
  for (GraphEdge& e : walk.graph.edges) e.expected_share = 0.1;
  EXPECT_TRUE(SurestChains(walk.graph, 0).to(29)->covariance.isApprox(0.01 * near->covariance, 1e-9));
  walk.graph.poses.push_back(Eigen::Isometry3d::Identity());
  EXPECT_FALSE(SurestChains(walk.graph, 0).to(30));  // nothing leads there
}

TEST(PoseGraph, ChainsAreTheSameFromBothEnds) {
  Walk walk(2);
  Random random(1);
  for (int i = 40; i < 80; i += 7) walk.graph.edges.push_back(walk.loop(i - 40, i, random));
  for (GraphEdge& e : walk.graph.edges) e.expected_share = random.uniform(0.5, 1);  // no two chains are alike
  const SurestChains from_first(walk.graph, 0);
  for (int i = 0; i < 80; i += 3) {
    const auto there = from_first.to(i), back = SurestChains(walk.graph, i).to(0);
    ASSERT_TRUE(there && back);
    EXPECT_TRUE(inverse(*back).T.isApprox(there->T, 1e-9)) << i;
    EXPECT_TRUE(inverse(*back).covariance.isApprox(there->covariance, 1e-9)) << i;
  }
}

TEST(PoseGraph, TheSameGraphGivesTheSameBits) {
  Walk a(4), b(4);
  for (Walk* walk : {&a, &b}) {
    Random random(9);
    for (int i = 40; i < 80; i += 5) walk->graph.edges.push_back(walk->loop(i - 40, i, random));
    optimise(walk->graph, {});
  }
  for (std::size_t i = 0; i < a.graph.poses.size(); ++i)
    EXPECT_EQ(a.graph.poses[i].matrix(), b.graph.poses[i].matrix());
}

TEST(UncertainTransform, CompoundsAndInvertsLikeSamples) {
  Random random(11);
  const UncertainTransform a{se3_exp(twist(1, 2, 0.5, 0.3, -0.2, 0.4)), covariance(0.02, 0.01)};
  const UncertainTransform b{se3_exp(twist(-0.5, 1, 0, 0.1, 0.5, -0.3)), covariance(0.01, 0.02)};
  const UncertainTransform both = a * b, back = inverse(a);
  Matrix6d of_both = Matrix6d::Zero(), of_back = Matrix6d::Zero();
  constexpr int samples = 20000;
  for (int i = 0; i < samples; ++i) {
    const Eigen::Isometry3d A = a.T * se3_exp(noise(random, 0.02, 0.01));
    const Eigen::Isometry3d B = b.T * se3_exp(noise(random, 0.01, 0.02));
    const Vector6d e = se3_log(both.T.inverse() * A * B), f = se3_log(back.T.inverse() * A.inverse());
    of_both += e * e.transpose() / samples;
    of_back += f * f.transpose() / samples;
  }
  EXPECT_LT((of_both - both.covariance).norm(), 0.05 * both.covariance.norm());
  EXPECT_LT((of_back - back.covariance).norm(), 0.05 * back.covariance.norm());
}

}  // namespace
}  // namespace lcmslam
