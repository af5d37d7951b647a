#include <lcmslam/simulation/ground.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/simulation/simulation.hpp>
#include <lcmslam/simulation/wheel_base.hpp>

#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

constexpr double degree = M_PI / 180, slope = 8 * degree;

GroundProfile profile(double x, double y, double yaw, std::vector<Eigen::Vector2d> points) {
  GroundProfile p;
  p.T_world_profile.translation() << x, y;
  p.T_world_profile.linear() = Eigen::Rotation2Dd(yaw).toRotationMatrix();
  p.width = 4;
  p.points = std::move(points);
  return p;
}

/// Rises from x = 1 for 10 m.
Ground ramp() {
  return Ground({profile(1, 0, 0, {{0, 0}, {10, 10 * std::tan(slope)}})});
}
Ground sill(double yaw = 0) {
  return Ground({profile(1, 0, yaw, {{0, 0}, {0.02, 0.02}, {0.12, 0.02}, {0.14, 0}})});
}

TEST(Ground, HasTheHeightOfItsHighestProfile) {
  const Ground two(
      {profile(1, 2, M_PI / 2, {{0, 0}, {1, 0.1}, {2, 0.1}}), profile(0, 2.2, 0, {{0, 0.03}, {2, 0.03}})});
  EXPECT_NEAR(two.height({1, 2.6}), 0.06, 1e-12);  // half way up, along y
  EXPECT_NEAR(two.height({1, 3.8}), 0.1, 1e-12);
  EXPECT_NEAR(two.height({1.2, 2.1}), 0.03, 1e-12);
  EXPECT_EQ(two.height({1, -1}), 0);
  EXPECT_EQ(two.height({5, 2.5}), 0);  // beside them
  EXPECT_THROW(Ground({profile(0, 0, 0, {{0, 0}, {0, 1}})}), std::invalid_argument);
  EXPECT_THROW(Ground({profile(0, 0, 0, {{0, 0}})}), std::invalid_argument);
}

// Against all points of the wheel's rim.
TEST(Ground, AWheelTouchesWhatItMeetsFirst) {
  constexpr double radius = 0.1;
  for (const double yaw : {0.0, 0.5}) {
    const Ground ground = sill(yaw);
    for (double x = 0.8; x < 1.4; x += 0.013) {
      double highest = 0;
      for (double u = -radius; u <= radius; u += 1e-5)
        highest = std::max(highest, ground.height({x + u, 0}) + std::sqrt(radius * radius - u * u) - radius);
      EXPECT_NEAR(ground.height_of_wheel({x, 0}, {1, 0}, radius), highest, 2e-5) << x;
    }
  }
}

TEST(Ground, ARobotStandsOnARampAsTheRampDoes) {
  const auto wheels = carrying_wheels("differential");
  for (const double heading : {0.0, 0.7, M_PI / 2, 3.0}) {
    const Eigen::Isometry3d T = stand_on(ramp(), wheels, planar_pose(5, 0.3, heading));
    EXPECT_LT((T.linear().col(2) - Eigen::Vector3d(-std::sin(slope), 0, std::cos(slope))).norm(), 1e-3)
        << heading;
    EXPECT_NEAR(yaw(T), heading, 1e-9);
    EXPECT_NEAR(T.translation().x(), 5, 1e-12);
    EXPECT_NEAR(T.translation().z(), 4 * std::tan(slope), 2e-3);  // a wheel's hub stands across the slope
    EXPECT_LT((T.linear() * T.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  }
  const Eigen::Isometry3d T_floor = planar_pose(-2, 0, 1);
  EXPECT_TRUE(stand_on(ramp(), wheels, T_floor).isApprox(T_floor, 1e-12));
}

TEST(Ground, WheelsMeasureTheWayAlongTheSlope) {
  const PlanarPath seen_from_above({{2, 0}, {4, 0}, {6, 0}});
  WheelErrors exact = WheelErrors::none();
  exact.quantum = 1e-7;
  for (const std::string base : {"differential", "steered", "mecanum"}) {
    const DrivenPath path(seen_from_above, ramp(), carrying_wheels(base));
    const auto readings = simulate_encoders(path, base, 0, 1, exact);
    const Wheel& wheel = readings.back().wheels.front();
    EXPECT_NEAR(wheel.radius * wheel.angle, 4 / std::cos(slope), 1e-3) << base;
  }
}

// The robot of the scene climbs what the cameras see, and comes down again.
TEST(Ground, OfTheKitchenWithARampIsWhatItsRobotStandsOn) {
  SimulationSettings settings;
  settings.scene = source_folder() / "config/scenes/kitchen_ramp.yaml";
  const Simulation simulation(settings);
  double highest = 0, steepest = 0;
  for (Utime t = simulation.start(); t < simulation.end(); t += 100'000) {
    const Eigen::Isometry3d T = simulation.T_world_robot(t);
    highest = std::max(highest, T.translation().z());
    steepest = std::max(steepest, std::acos(T.linear()(2, 2)));
    for (const CarryingWheel& wheel : carrying_wheels(settings.base))
      EXPECT_LT(simulation.distance_to_surface(T * Eigen::Vector3d(wheel.x, wheel.y, 0)), 0.012);
  }
  EXPECT_NEAR(highest, 0.1405, 1e-3);
  EXPECT_NEAR(steepest, slope, 2e-3);
  EXPECT_LT(simulation.T_world_robot(simulation.end()).translation().z(), 1e-6);
}

}  // namespace
}  // namespace lcmslam
