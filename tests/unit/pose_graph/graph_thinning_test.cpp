// Nodes that go: which, and that what was measured stays known.

#include <lcmslam/pose_graph/graph_thinning.hpp>

#include <gmock/gmock.h>

#include <cmath>

#include "tests/unit/dense_mapper/gallery.hpp"

namespace lcmslam {
namespace {

Matrix6d diagonal(double translation, double rotation) {
  Vector6d d;
  d << Eigen::Vector3d::Constant(translation * translation), Eigen::Vector3d::Constant(rotation * rotation);
  return d.asDiagonal();
}

Eigen::Isometry3d some_pose(Random& random) {
  return se3_exp(twist(random.normal(), random.normal(), random.normal(), 0.4 * random.normal(),
                       0.4 * random.normal(), 0.4 * random.normal()));
}

GraphEdge edge(int from, int to, EdgeKind kind, const UncertainTransform& T) {
  return {from, to, kind, T, 0};
}

TEST(Marginalise, ComposesThePathAndContinuesLoops) {
  Random random(3);
  const UncertainTransform a{some_pose(random), diagonal(0.02, 0.01)},
      b{some_pose(random), diagonal(0.01, 0.01)}, loop{some_pose(random), diagonal(0.005, 0.002)};
  std::vector<GraphEdge> edges = {edge(3, 4, EdgeKind::odometry, a), edge(4, 5, EdgeKind::odometry, b),
                                  edge(0, 4, EdgeKind::loop, loop), edge(0, 1, EdgeKind::odometry, a)};
  std::vector<GraphEdge> waiting = {edge(1, 4, EdgeKind::loop, loop)};
  marginalise(4, edges, waiting);
  ASSERT_EQ(edges.size(), 3U);
  for (const GraphEdge& e : edges) EXPECT_LT(e.from, e.to);
  const GraphEdge& untouched = edges[0];
  EXPECT_EQ(untouched.to, 1);
  const auto between = [&](int from, int to) {
    return *std::find_if(edges.begin(), edges.end(),
                         [&](const GraphEdge& e) { return e.from == from && e.to == to; });
  };
  const GraphEdge path = between(3, 5), continued = between(0, 5);  // 5: the surer neighbour
  EXPECT_EQ(path.kind, EdgeKind::odometry);
  EXPECT_EQ(continued.kind, EdgeKind::loop);
  const UncertainTransform ab = a * b, loop_b = loop * b;
  EXPECT_TRUE(path.T_from_to.T.isApprox(ab.T, 1e-9));
  EXPECT_TRUE(path.T_from_to.covariance.isApprox(ab.covariance, 1e-6));
  EXPECT_TRUE(continued.T_from_to.T.isApprox(loop_b.T, 1e-9));
  EXPECT_TRUE(continued.T_from_to.covariance.isApprox(loop_b.covariance, 1e-6));
  ASSERT_EQ(waiting.size(), 1U);
  EXPECT_EQ(waiting[0].to, 5);
  EXPECT_TRUE(waiting[0].T_from_to.T.isApprox(loop_b.T, 1e-9));
}

TEST(Marginalise, WhatContinuesOverOdometryIsExpectedAsThatIs) {
  const UncertainTransform step{Eigen::Isometry3d::Identity(), diagonal(0.01, 0.01)};
  std::vector<GraphEdge> edges = {edge(3, 4, EdgeKind::odometry, step), edge(4, 5, EdgeKind::odometry, step),
                                  edge(0, 4, EdgeKind::loop, step)};
  std::vector<GraphEdge> waiting;
  edges[0].expected_share = 0.1;
  marginalise(4, edges, waiting);
  ASSERT_EQ(edges.size(), 2U);
  for (const GraphEdge& e : edges) EXPECT_EQ(e.expected_share, 0.1) << e.from << " to " << e.to;
}

// A registration beside odometry's edge makes that sure to a centimetre, which is told cautiously already.
TEST(Marginalise, WhatRegistrationSharpensIsExpectedAsThatIs) {
  const Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  GraphEdge led = edge(3, 4, EdgeKind::odometry, {T, diagonal(0.3, 0.2)});
  led.expected_share = 0.1;
  GraphEdge onwards = led;
  onwards.from = 4;
  onwards.to = 5;
  const UncertainTransform seen{T, diagonal(0.01, 0.005)};
  std::vector<GraphEdge> edges = {led, onwards, edge(3, 4, EdgeKind::registration, seen),
                                  edge(4, 5, EdgeKind::registration, seen)};
  std::vector<GraphEdge> waiting;
  EXPECT_EQ(merged(led, edges[2]).expected_share, 1);
  EXPECT_EQ(merged(edges[2], led).expected_share, 1);
  marginalise(4, edges, waiting);
  ASSERT_EQ(edges.size(), 2U);
  const auto continued = std::find_if(edges.begin(), edges.end(),
                                      [](const GraphEdge& e) { return e.kind == EdgeKind::registration; });
  ASSERT_NE(continued, edges.end());
  const double expected = continued->expected_share * std::sqrt(continued->T_from_to.covariance(0, 0));  // m
  EXPECT_NEAR(expected, std::sqrt(2.0) * 0.01, 1e-4);
}

TEST(Marginalise, ParallelEdgesBecomeOne) {
  Random random(4);
  const Eigen::Isometry3d T = some_pose(random);
  const GraphEdge a = edge(0, 1, EdgeKind::loop, {T, diagonal(0.01, 0.01)});
  GraphEdge b = a;
  b.T_from_to.T = T * se3_exp(twist(0.02, 0, 0, 0, 0, 0));
  const GraphEdge one = merged(a, b);
  EXPECT_TRUE(one.T_from_to.covariance.isApprox(0.5 * a.T_from_to.covariance, 1e-9));
  EXPECT_TRUE((T.inverse() * one.T_from_to.T).isApprox(se3_exp(twist(0.01, 0, 0, 0, 0, 0)), 1e-9));
  // Two loops to nodes that go end at one.
  const UncertainTransform step{Eigen::Isometry3d::Identity(), diagonal(0.01, 0.01)};
  std::vector<GraphEdge> edges, waiting;
  for (int i = 0; i < 8; ++i) edges.push_back(edge(i, i + 1, EdgeKind::odometry, step));
  for (int i = 4; i < 8; ++i) edges.push_back(edge(0, i, EdgeKind::loop, step));
  for (const int gone : {4, 5, 6}) marginalise(gone, edges, waiting);
  int loops = 0, odometry = 0;
  for (const GraphEdge& e : edges) (e.kind == EdgeKind::odometry ? odometry : loops) += 1;
  EXPECT_EQ(odometry, 5);  // 0 1 2 3 7 8 in one piece
  EXPECT_LE(loops, 2);
  EXPECT_GE(loops, 1);
}

/// Three laps around a square with noisy odometry and noisy observations of the lap before.
PoseGraph laps(std::uint64_t seed, std::vector<Eigen::Isometry3d>& truth) {
  Random random(seed);
  const auto noisy = [&](const Eigen::Isometry3d& T, double m, double rad) {
    return T * se3_exp(twist(random.normal(0, m), random.normal(0, m), random.normal(0, m),
                             random.normal(0, rad), random.normal(0, rad), random.normal(0, rad)));
  };
  constexpr int around = 24;
  for (int i = 0; i < 3 * around; ++i) {
    const double angle = 2 * M_PI * i / around;
    truth.push_back(planar_pose(3 * std::cos(angle), 3 * std::sin(angle), angle));
  }
  PoseGraph graph;
  graph.poses.push_back(truth[0]);
  for (int i = 1; i < 3 * around; ++i) {
    const Eigen::Isometry3d step =
        truth[static_cast<std::size_t>(i - 1)].inverse() * truth[static_cast<std::size_t>(i)];
    graph.edges.push_back(
        edge(i - 1, i, EdgeKind::odometry, {noisy(step, 0.02, 0.01), diagonal(0.02, 0.01)}));
    graph.poses.push_back(graph.poses.back() * graph.edges.back().T_from_to.T);
    if (i < around) continue;
    const int before = i - around;
    const Eigen::Isometry3d back =
        truth[static_cast<std::size_t>(before)].inverse() * truth[static_cast<std::size_t>(i)];
    graph.edges.push_back(edge(before, i, EdgeKind::loop, {noisy(back, 0.01, 0.005), diagonal(0.01, 0.005)}));
  }
  return graph;
}

double rms_error(const PoseGraph& graph, const std::vector<Eigen::Isometry3d>& truth,
                 const std::vector<int>& nodes) {
  double sum = 0;
  for (const int i : nodes)
    sum += (graph.poses[static_cast<std::size_t>(i)].translation() -
            truth[static_cast<std::size_t>(i)].translation())
               .squaredNorm();
  return std::sqrt(sum / static_cast<double>(nodes.size()));
}

// Standard deviation (m) of a node's place when the first one is known: all edges linearised at the poses.
double spread(const PoseGraph& graph, int node) {
  const auto n = static_cast<Eigen::Index>(6 * graph.poses.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
  H.diagonal().head<6>().setConstant(1e12);
  for (std::size_t i = 0; i < graph.poses.size(); ++i)  // nodes without edges
    H.diagonal().segment<6>(static_cast<Eigen::Index>(6 * i)).array() += 1e-9;
  for (const GraphEdge& e : graph.edges) {
    const Eigen::Index i = 6 * e.from, j = 6 * e.to;
    const Matrix6d information = e.T_from_to.covariance.inverse();
    const Matrix6d A = -adjoint(e.T_from_to.T.inverse());
    H.block<6, 6>(i, i) += A.transpose() * information * A;
    H.block<6, 6>(j, j) += information;
    H.block<6, 6>(i, j) += A.transpose() * information;
    H.block<6, 6>(j, i) += information * A;
  }
  const Eigen::MatrixXd covariance = H.inverse();
  return std::sqrt(covariance.block<3, 3>(6 * node, 6 * node).trace());
}

TEST(Marginalise, KeepsWhatTheGraphKnows) {
  double full = 0, thin = 0, start = 0, overconfidence = 0;
  constexpr int seeds = 10;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    std::vector<Eigen::Isometry3d> truth;
    PoseGraph graph = laps(seed, truth), thinned = graph;
    std::vector<GraphEdge> waiting;
    std::vector<int> kept;
    for (int i = 0; i < static_cast<int>(truth.size()); ++i)
      if (i % 3 == 1 && i > 0)
        marginalise(i, thinned.edges, waiting);
      else
        kept.push_back(i);
    EXPECT_LT(thinned.edges.size(), graph.edges.size());
    start += rms_error(graph, truth, kept);
    EXPECT_EQ(optimise(graph, {}), 0);
    EXPECT_EQ(optimise(thinned, {}), 0);
    full += rms_error(graph, truth, kept);
    thin += rms_error(thinned, truth, kept);
    for (const int node : {11, 36, 60})
      overconfidence = std::max(overconfidence, spread(graph, node) / spread(thinned, node));
  }
  std::cout << "rms " << start / seeds << " m before, " << full / seeds << " with all nodes, " << thin / seeds
            << " with two thirds; surer by a factor " << overconfidence << "\n";
  EXPECT_LT(full, 0.5 * start);
  EXPECT_LT(thin, 1.2 * full);
  EXPECT_LT(overconfidence, 1.1);
}

TEST(SurestEdges, StayAtEitherEnd) {
  const auto sure = [](int from, int to, EdgeKind kind, double sigma) {
    return edge(from, to, kind, {Eigen::Isometry3d::Identity(), diagonal(sigma, sigma)});
  };
  const std::vector<GraphEdge> edges = {
      sure(0, 1, EdgeKind::odometry, 0.9),    sure(0, 9, EdgeKind::loop, 0.03),
      sure(0, 8, EdgeKind::loop, 0.01),       sure(0, 7, EdgeKind::loop, 0.02),
      sure(1, 9, EdgeKind::loop, 0.01),       sure(2, 9, EdgeKind::loop, 0.02),
      sure(0, 2, EdgeKind::registration, 0.5)};
  const auto kept = surest_edges(edges, 10, 2);
  // The third of 0 is the third of 9, too; odometry and another kind do not count.
  ASSERT_EQ(kept.size(), 6U);
  for (const GraphEdge& e : kept) EXPECT_FALSE(e.from == 0 && e.to == 9);
  EXPECT_EQ(kept.front().kind, EdgeKind::odometry);
  EXPECT_EQ(kept.back().kind, EdgeKind::registration);
  const auto fewer = surest_edges(edges, 10, 1);
  EXPECT_EQ(fewer.size(), 6U) << "2-9 is the only one of 2, 0-7 of 7";
  EXPECT_TRUE(surest_edges({}, 0, 2).empty());
}

TEST(CoveredNodes, TheMostRedundantGo) {
  std::vector<ThinningNode> nodes;
  const auto add = [&](double x, double heading, bool keyframe, bool fixed = false) {
    nodes.push_back({planar_pose(x, 0, heading), keyframe, fixed});
  };
  add(0, 0, true, true);
  add(0.02, 0, true);  // beside the first one
  for (int i = 1; i < 6; ++i) add(0.5 * i, 0, true);
  add(1.0, 1.5, true);  // looks elsewhere
  add(1.51, 0, true);   // beside node 4, newer
  add(2.2, 0, false);
  add(2.01, 0, false);  // nearest to a keyframe
  const auto gone = covered_nodes(nodes, 7, 1);
  std::vector<int> which;
  for (std::size_t i = 0; i < gone.size(); ++i)
    if (gone[i]) which.push_back(static_cast<int>(i));
  EXPECT_THAT(which, testing::ElementsAre(1, 8, 10));
  const auto successor = successors(nodes, gone);
  EXPECT_EQ(successor[1], 0);
  EXPECT_EQ(successor[8], 4);
  EXPECT_EQ(successor[10], 5);
  EXPECT_EQ(successor[7], 7);
  // Fixed ones stay, whatever the limit.
  for (ThinningNode& n : nodes) n.fixed = true;
  for (const bool g : covered_nodes(nodes, 0, 0)) EXPECT_FALSE(g);
}

}  // namespace
}  // namespace lcmslam
