// The robot's path from its cameras' path, with a head that sits elsewhere than is told.

#include <lcmslam/geometry/mount_error.hpp>

#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/pose_graph/pose_covariance.hpp>

namespace lcmslam {
namespace {

const MountErrorSettings settings{0.004, 0.003};

Eigen::Isometry3d placed(double x, double y, double yaw) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << x, y, 0;
  T.rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  return T;
}

Eigen::Isometry3d mounted() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 0.2, 0, 1.1;
  T.rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY()));
  return T * optical_axes();
}

Vector6d draw(Random& random) {
  Vector6d m;
  for (int k = 0; k < 6; ++k)
    m(k) = random.normal(0, k < 3 ? settings.translation_sigma : settings.rotation_sigma);
  return m;
}

// Draws of the head's true place: the told mean square of the path's errors is theirs.
TEST(MountError, IsWhatDrawnMountsMakeOfThePath) {
  const Eigen::Isometry3d told = mounted(), T = placed(3, -1, 2.5);
  Matrix6d sum = Matrix6d::Zero();
  Random random(3);
  constexpr int draws = 20000;
  for (int i = 0; i < draws; ++i) {
    const Eigen::Isometry3d built = told * se3_exp(draw(random));
    const Eigen::Isometry3d T_first_now = built.inverse() * T * built;  // as the cameras see it
    const Vector6d error = se3_log((told * T_first_now * told.inverse()).inverse() * T);
    sum += error * error.transpose() / draws;
  }
  const Matrix6d P = mount_error(told.inverse() * T * told, told, settings.sigmas(told), Matrix6d::Zero());
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(P(i, j), sum(i, j), 0.05 * std::sqrt(P(i, i) * P(j, j)) + 1e-9) << i << " " << j;
}

TEST(MountError, IsNothingAtTheStartAndForACameraInTheHand) {
  const Eigen::Isometry3d start = placed(0, 0, 0);
  EXPECT_LT(mount_error(start, mounted(), settings.sigmas(mounted()), Matrix6d::Zero()).norm(), 1e-18);
  EXPECT_EQ(settings.sigmas(optical_axes()).norm(), 0);
}

Matrix6d step_covariance() {
  Vector6d d;
  d << Eigen::Vector3d::Constant(1e-4), Eigen::Vector3d::Constant(2.5e-5);
  return d.asDiagonal();
}

PoseGraphSettings least_squares() {
  PoseGraphSettings s;
  s.edge_error = s.ground_error = 1;
  s.motion_scale = s.turn_scale = s.curvature = 0;
  s.kernel_width = s.max_error = 1e6;
  return s;
}

Vector6d camera_noise(Random& random) {
  Vector6d v;
  for (int k = 0; k < 6; ++k) v(k) = std::sqrt(step_covariance()(k, k)) * random.normal();
  return v;
}

Vector6d floor_noise(Random& random, const GroundSettings& floor) {
  Vector6d v = Vector6d::Zero();
  v.segment<3>(2) << random.normal(0, floor.height), random.normal(0, floor.tilt),
      random.normal(0, floor.tilt);
  return v;
}

/// A robot drives round in a circle and its cameras measure exactly; a graph that holds it to the floor with
/// the mount as it is told. With `noise` the cameras err, and the floor is uneven, as the graph believes.
struct Circle {
  std::vector<Eigen::Isometry3d> robot;
  Eigen::Isometry3d told = mounted();
  PoseGraph graph;

  Circle(const Vector6d& m, const GroundSettings& floor, Random* noise = nullptr) {
    const Eigen::Isometry3d built = told * se3_exp(m);
    Eigen::Isometry3d T = placed(0, 0, 0);
    for (int i = 0; i < 20; ++i, T = T * placed(0.5, 0, M_PI / 10)) {
      robot.push_back(i > 0 && noise != nullptr ? T * se3_exp(floor_noise(*noise, floor)) : T);
      graph.poses.push_back(told * built.inverse() * robot.back() * built);
      if (i == 0) continue;
      Eigen::Isometry3d step = graph.poses[graph.poses.size() - 2].inverse() * graph.poses.back();
      if (noise != nullptr) step = step * se3_exp(camera_noise(*noise));
      graph.edges.push_back({i - 1, i, EdgeKind::odometry, {step, step_covariance()}, 0});
    }
    graph.ground = GroundConstraint{told.inverse(), floor, {}, settings.sigmas(told)};
  }

  Vector6d error(std::size_t i) const {
    return se3_log((graph.poses[i] * told.inverse()).inverse() * robot[i]);
  }
};

// With a floor that is believed firmly, as much as the cameras, and hardly.
TEST(MountError, IsHeldWhereTheGraphHoldsTheRobotToTheFloor) {
  Random random(5);
  const Vector6d m = draw(random);
  std::vector<double> tilt;
  for (const int k : {0, 1, 2}) {
    const double weight = k == 0 ? 0.05 : k == 1 ? 1 : 50;
    Circle circle(m, GroundSettings{weight * 0.01, weight * 0.005});
    optimise(circle.graph, least_squares());
    const auto errors = pose_errors(circle.graph, least_squares());
    for (std::size_t i = 1; i < errors.size(); ++i) {
      const Vector6d moved = errors[i].by_mount * m.cwiseQuotient(settings.sigmas(circle.told));
      const Eigen::Isometry3d T_first_now = circle.graph.poses[0].inverse() * circle.graph.poses[i];
      const Vector6d told = adjoint(circle.told) * (moved - mount_lever(T_first_now) * m);
      EXPECT_LT((circle.error(i) - told).norm(), 0.03 * m.norm()) << k << " " << i;
    }
    tilt.push_back(circle.error(10).segment<2>(3).norm());
  }
  EXPECT_LT(tilt.front(), 0.1 * tilt.back());
}

// From one node to the next by Kalman's filter, as by the graph's equations.
TEST(MountError, IsCarriedToANewNodeAsTheGraphWouldHaveIt) {
  Circle circle(Vector6d::Zero(), GroundSettings{});
  circle.graph.poses.resize(2);
  circle.graph.edges.resize(1);
  const auto [from, to] = std::make_pair(circle.graph.poses[0], circle.graph.poses[1]);
  const PoseError solved = pose_errors(circle.graph, least_squares())[1];
  const PoseError carried = on_ground(carried_along({}, {from.inverse() * to, step_covariance()}),
                                      from.inverse() * to, *circle.graph.ground, least_squares(), {});
  EXPECT_GT(solved.by_mount.norm(), 1e-4);
  EXPECT_LT((solved.by_mount - carried.by_mount).norm(), 1e-9 * solved.by_mount.norm());
  EXPECT_LT((solved.own - carried.own).norm(), 1e-9 * solved.own.norm());
}

// Drives on uneven ground with noisy cameras and a head that sits elsewhere: what the robot errs by at nodes
// on the way, as the optimised graph has them.
TEST(MountError, IsInWhatTheRobotErrsByAtEachNode) {
  constexpr int seeds = 100;
  const GroundSettings floor{0.003, 0.002};
  double sum = 0, without = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Random random(seed);
    Circle circle(3 * draw(random), floor, &random);  // large beside what cameras and ground err by
    circle.graph.ground->mount_sigmas *= 3;
    optimise(circle.graph, least_squares());
    const auto errors = pose_errors(circle.graph, least_squares());
    for (const std::size_t i : {4U, 9U, 14U}) {
      const Eigen::Isometry3d T_first_now = circle.graph.poses[0].inverse() * circle.graph.poses[i];
      const Vector6d e = circle.error(i);
      const auto nees = [&](const Vector6d& mount_sigmas, const PoseError& error) {
        return e.dot(robot_covariance(error, T_first_now, circle.told, mount_sigmas).ldlt().solve(e));
      };
      sum += nees(circle.graph.ground->mount_sigmas, errors[i]);
      without += nees(Vector6d::Zero(), {errors[i].own, Matrix6d::Zero()});
      ++count;
    }
  }
  EXPECT_NEAR(sum / count, 6, 0.6);  // 300 chi squares of 6, those of one seed correlated: sigma below 0.35
  EXPECT_GT(without / count, 7.5);
}

}  // namespace
}  // namespace lcmslam
