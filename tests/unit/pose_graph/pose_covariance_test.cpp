// The marginal covariances of a graph's poses: against a dense inverse with numeric Jacobians, and against
// what poses really err by.

#include <lcmslam/pose_graph/pose_covariance.hpp>

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/pose_graph/keyframe_graph.hpp>
#include "tests/support/cloud_scenes.hpp"
#include "tests/unit/dense_mapper/gallery.hpp"

namespace lcmslam {
namespace {

constexpr double edge_sigma_t = 0.01, edge_sigma_r = 0.005;

Matrix6d edge_covariance() {
  Vector6d d;
  d << Eigen::Vector3d::Constant(edge_sigma_t * edge_sigma_t),
      Eigen::Vector3d::Constant(edge_sigma_r * edge_sigma_r);
  return d.asDiagonal();
}

Vector6d edge_noise(Random& random) {
  Vector6d v;
  for (int i = 0; i < 6; ++i) v(i) = (i < 3 ? edge_sigma_t : edge_sigma_r) * random.normal();
  return v;
}

PoseGraphSettings exact_settings() {
  PoseGraphSettings settings;
  settings.edge_error = 1;
  settings.motion_scale = settings.turn_scale = settings.curvature = 0;
  settings.kernel_width = 1e6;  // plain least squares: what the covariances are of
  settings.max_error = 1e6;
  return settings;
}

/// Round a square of 5 m, one and a half times; the second round sees the first again.
struct Round {
  std::vector<Eigen::Isometry3d> truth;
  PoseGraph graph;

  explicit Round(std::uint64_t seed) {
    Random random(seed);
    Eigen::Isometry3d T = se3_exp(twist(1, 2, 3, 0.1, 0.2, 0.3));
    for (int i = 0; i < 30; ++i) {
      if (i > 0) T = T * se3_exp(twist(1, 0, 0, 0, 0, i % 5 == 0 ? M_PI / 2 : 0));
      truth.push_back(T);
      if (i > 0) add(i - 1, i, EdgeKind::odometry, random);
      if (i > 20) add(i - 20, i, EdgeKind::loop, random);
      graph.poses.push_back(i == 0 ? T : graph.poses.back() * graph.edges[odometry_].T_from_to.T);
    }
  }

  void add(int from, int to, EdgeKind kind, Random& random) {
    if (kind == EdgeKind::odometry) odometry_ = graph.edges.size();
    const Eigen::Isometry3d T =
        truth[static_cast<std::size_t>(from)].inverse() * truth[static_cast<std::size_t>(to)];
    graph.edges.push_back({from, to, kind, {T * se3_exp(edge_noise(random)), edge_covariance()}, 0});
  }

 private:
  std::size_t odometry_ = 0;
};

Vector6d error_at(const GraphEdge& e, const std::vector<Eigen::Isometry3d>& poses) {
  return se3_log(e.T_from_to.T.inverse() * poses[static_cast<std::size_t>(e.from)].inverse() *
                 poses[static_cast<std::size_t>(e.to)]);
}

TEST(PoseCovariance, IsTheDenseInverseOfTheNumericInformation) {
  Round round(1);
  round.graph.poses = round.truth;
  round.graph.ground = GroundConstraint{se3_exp(twist(0.1, 0.2, -0.3, 0.4, 0.1, 0.2)), {}, {}};
  for (GraphEdge& e : round.graph.edges)  // exact ones, where Jacobians are those of the error
    e.T_from_to.T =
        round.truth[static_cast<std::size_t>(e.from)].inverse() * round.truth[static_cast<std::size_t>(e.to)];
  const PoseGraphSettings settings = exact_settings();
  const auto n = static_cast<Eigen::Index>(round.truth.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(6 * n, 6 * n);
  constexpr double step = 1e-5;
  for (const GraphEdge& e : round.graph.edges) {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6, 6 * n);
    for (const int node : {e.from, e.to})
      for (int k = 0; k < 6; ++k) {
        std::vector<Eigen::Isometry3d> plus = round.truth, minus = round.truth;
        const auto i = static_cast<std::size_t>(node);
        plus[i] = plus[i] * se3_exp(step * Vector6d::Unit(k));
        minus[i] = minus[i] * se3_exp(-step * Vector6d::Unit(k));
        J.col(6 * node + k) = (error_at(e, plus) - error_at(e, minus)) / (2 * step);
      }
    H += J.transpose() * edge_covariance().inverse() * J;
  }
  for (Eigen::Index node = 1; node < n; ++node)  // the robot's height and tilt in its own frame
    for (const int k : {2, 3, 4}) {
      const GroundSettings& plane = round.graph.ground->plane;
      const double sigma = settings.ground_error * (k == 2 ? plane.height : plane.tilt);
      const Vector6d row = adjoint(round.graph.ground->T_camera_robot.inverse()).row(k).transpose() / sigma;
      H.block<6, 6>(6 * node, 6 * node) += row * row.transpose();
    }
  const Eigen::MatrixXd dense = H.bottomRightCorner(6 * (n - 1), 6 * (n - 1)).inverse();
  const std::vector<PoseError> sparse = pose_errors(round.graph, settings);
  ASSERT_EQ(sparse.size(), round.truth.size());
  EXPECT_TRUE(sparse.front().covariance().isZero());
  for (Eigen::Index node = 1; node < n; ++node) {
    const Matrix6d expected = dense.block<6, 6>(6 * (node - 1), 6 * (node - 1));
    EXPECT_LT((sparse[static_cast<std::size_t>(node)].covariance() - expected).norm(), 1e-4 * expected.norm())
        << node;
  }
}

TEST(PoseCovariance, IsWhatOptimisedPosesErrBy) {
  constexpr int seeds = 60;
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Round round(seed);
    optimise(round.graph, exact_settings());
    const auto covariances = pose_errors(round.graph, exact_settings());
    for (const std::size_t node : {10U, 19U, 29U}) {
      const Vector6d e = se3_log(round.graph.poses[node].inverse() * round.truth[node]);
      sum += e.dot(covariances[node].covariance().inverse() * e);
      ++count;
    }
  }
  EXPECT_NEAR(sum / count, 6, 0.9);  // 180 chi squares of 6, those of one seed correlated: sigma below 0.45
}

/// What edges of one stretch err by together.
struct Shared {
  double longer, bent;
};

// Every edge of a stretch measures ways too long by one ratio and bends straight ways, and every edge of the
// drive turns too far by another.
void expect_honest_where_edges_err_together(double stretch) {
  PoseGraphSettings settings = exact_settings();
  settings.motion_scale = 0.01;
  settings.turn_scale = 0.02;
  settings.curvature = 0.02;
  settings.stretch = stretch;
  constexpr int seeds = 150;
  double sum = 0, alone = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Round round(seed);
    Random random(seed, 7);
    const double farther = random.normal(0, settings.turn_scale);
    std::vector<Shared> stretches;
    for (const GraphEdge& e : round.graph.edges) {  // nodes are 1 m apart
      const auto s = static_cast<std::size_t>(std::max(e.from, e.to) / stretch);
      while (stretches.size() <= s)
        stretches.push_back({random.normal(0, settings.motion_scale), random.normal(0, settings.curvature)});
    }
    for (GraphEdge& e : round.graph.edges) {
      const Shared& shared = stretches[static_cast<std::size_t>(std::max(e.from, e.to) / stretch)];
      const Eigen::Isometry3d& T_to = round.truth[static_cast<std::size_t>(e.to)];
      Vector6d motion = se3_log(e.T_from_to.T);
      motion.head<3>() = e.T_from_to.T.linear().transpose() * e.T_from_to.T.translation() * shared.longer;
      motion.tail<3>() =
          farther * motion.tail<3>() + shared.bent * e.T_from_to.T.translation().norm() *
                                           (T_to.linear().transpose() * Eigen::Vector3d::UnitZ());
      e.T_from_to.T = e.T_from_to.T * se3_exp(motion);
    }
    optimise(round.graph, settings);
    const auto covariances = pose_errors(round.graph, settings);
    const auto own = pose_errors(round.graph, exact_settings());
    for (const std::size_t node : {10U, 19U, 29U}) {
      const Vector6d e = se3_log(round.graph.poses[node].inverse() * round.truth[node]);
      sum += e.dot(covariances[node].covariance().inverse() * e);
      alone += e.dot(own[node].covariance().inverse() * e);
      ++count;
    }
  }
  EXPECT_NEAR(sum / count, 6, 0.9) << stretch;
  EXPECT_GT(alone / count, 15) << stretch;  // as if edges erred on their own
}

TEST(PoseCovariance, HoldsWhatAllEdgesErrByTogether) {
  expect_honest_where_edges_err_together(1000);
  expect_honest_where_edges_err_together(7.5);
}

// Edges that contradict each other err by more on their own; of what they share that tells nothing.
TEST(PoseCovariance, WhatEdgesShareDoesNotGrowWithWhatTheyContradict) {
  PoseGraphSettings settings = exact_settings();
  settings.motion_scale = settings.turn_scale = settings.curvature = 0.02;
  Round round(1);
  const auto stated = pose_errors(round.graph, settings), alone = pose_errors(round.graph, exact_settings());
  const ErrorFactors contradicting{3, 1};
  const auto larger = pose_errors(round.graph, settings, contradicting);
  for (const std::size_t node : {10U, 19U, 29U}) {
    const Matrix6d shared = stated[node].own - alone[node].own;
    EXPECT_GT(shared.trace(), alone[node].own.trace());
    EXPECT_LT((larger[node].own - 9 * alone[node].own - shared).norm(), 1e-9 * shared.norm()) << node;
  }
}

void expect_same(const std::vector<PoseError>& a, const std::vector<PoseError>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_LT((a[i].own - b[i].own).norm(), 1e-9 * b[i].own.norm() + 1e-18) << i;
    EXPECT_LT((a[i].by_mount - b[i].by_mount).norm(), 1e-9 * b[i].by_mount.norm() + 1e-18) << i;
  }
}

// What is measured twice with the same error is known no better for it; a loop says something else than the
// way.
TEST(PoseCovariance, EdgesThatErrAlikeCountAsOne) {
  PoseGraphSettings settings = exact_settings();
  settings.motion_scale = 0.01;
  settings.turn_scale = 0.02;
  settings.curvature = 0.02;
  Round round(1);
  Vector6d mount;
  mount << 0.01, 0.01, 0.01, 0.02, 0.02, 0.02;
  round.graph.ground = GroundConstraint{se3_exp(twist(0.1, 0.2, -0.3, 0.4, 0.1, 0.2)), {}, {}, mount};
  const auto once = pose_errors(round.graph, settings);
  expect_same(pose_errors(round.graph, settings, {}, EdgeErrors::alike), once);
  PoseGraph repeated = round.graph;
  for (const GraphEdge& e : round.graph.edges)
    for (int again = 0; again < (e.from % 3); ++again) {
      repeated.edges.push_back(e);
      if (e.kind == EdgeKind::odometry) repeated.edges.back().kind = EdgeKind::registration;
    }
  expect_same(pose_errors(repeated, settings, {}, EdgeErrors::alike), once);
  const auto surer = pose_errors(repeated, exact_settings()).back().own.trace();
  EXPECT_LT(surer, 0.8 * pose_errors(round.graph, exact_settings()).back().own.trace());
}

TEST(PoseCovariance, KnowsNothingOfWhatIsNotTied) {
  Round round(1);
  round.graph.poses.push_back(round.truth.back());
  EXPECT_TRUE(pose_errors(round.graph, exact_settings()).empty());
}

// Out and back again: it grows with the way into new ground, and where the loop closes it is small again.
TEST(PoseCovariance, GrowsWithTheWayAndShrinksAtTheLoop) {
  Gallery gallery(4);
  KeyframeGraphSettings settings;
  settings.optimiser.stated_measurements = 1e6;  // how well edges agree shall not make them surer on the way
  KeyframeGraph graph(settings);
  Utime now = 1'000'000;
  std::vector<double> carried;
  for (int i = 0; i <= 20; ++i, now += 1'000'000) {
    const Eigen::Isometry3d T(Eigen::Translation3d(i <= 10 ? 0.4 * i : 0.4 * (20 - i), 0, 0));
    graph.add(now, T, 1e-6 * Matrix6d::Identity(), gallery.seen_from(T), i <= 10);
    carried.push_back(graph.nodes().back().error.covariance().topLeftCorner<3, 3>().trace());
    for (const Utime later : {Utime(0), Utime(500'000)})
      if (const auto correction = graph.work(now + later)) graph.apply(*correction);
  }
  EXPECT_EQ(carried.front(), 0);
  EXPECT_GT(carried[10], carried[1]);
  if (const auto correction = graph.finish()) graph.apply(*correction);
  const auto size = [&](std::size_t node) {
    return graph.nodes()[node].error.covariance().topLeftCorner<3, 3>().trace();
  };
  EXPECT_GT(size(10), 2 * size(1));
  EXPECT_GT(size(10), 2 * size(20));
  // As part of the map: what the graph's edges leave when they err alike.
  PoseGraph solved;
  for (const auto& node : graph.nodes()) solved.poses.push_back(node.T_world_camera);
  solved.edges = graph.edges();
  const auto alike = pose_errors(solved, settings.optimiser, graph.error_factors(), EdgeErrors::alike);
  for (const std::size_t i : {5U, 10U, 15U}) {
    EXPECT_LT((graph.nodes()[i].map_error.own - alike[i].own).norm(), 0.02 * alike[i].own.norm()) << i;
    EXPECT_GT(alike[i].own.trace(), 1.1 * graph.nodes()[i].error.own.trace()) << i;
  }
}

}  // namespace
}  // namespace lcmslam
