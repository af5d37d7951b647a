// How far new surfaces may lead a robot against its wheels.

#include <gtest/gtest.h>

#include <lcmslam/dense_mapper/settled_way.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {
namespace {

Eigen::Isometry3d ahead(double x) {
  return planar_pose(x, 0, 0);
}

Motion wheels_ahead(double step, double sigma) {
  Motion motion;
  motion.T_from_to = ahead(step);
  motion.covariance = sigma * sigma * Matrix6d::Identity();
  return motion;
}

SettledPairs settled_along(std::initializer_list<int> directions) {
  SettledPairs pairs;
  for (const int i : directions) pairs.information(i, i) = 1e7;
  return pairs;
}

RegistrationResult led_to(const Eigen::Isometry3d& T, const SettledPairs& settled) {
  RegistrationResult placed;
  placed.T_target_source = T;
  placed.settled = settled;
  return placed;
}

struct Drive {
  int held = 0, first_held = -1;
  double furthest = 0;  // m, from where the wheels have led
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
};

// A robot drives by so much a step, say its wheels, and registration leads it by another.
Drive drive(int steps, double by_wheels, double by_surfaces, const SettledPairs& settled,
            double wheel_sigma = 1e-3) {
  SettledWay way;
  Drive result;
  for (int i = 0; i < steps; ++i) {
    const Eigen::Isometry3d T_expected = result.T * ahead(by_wheels);
    result.T = result.T * ahead(by_surfaces);
    const auto T_held =
        way.observe(wheels_ahead(by_wheels, wheel_sigma), T_expected, led_to(result.T, settled));
    if (T_held) {
      result.T = *T_held;
      if (result.held++ == 0) result.first_held = i;
    }
    result.furthest = std::max(result.furthest, std::abs(result.T.translation().x() - by_wheels * (i + 1)));
  }
  return result;
}

TEST(SettledWay, HoldsARobotThatNewSurfacesTakeAlong) {
  const Drive taken = drive(200, 0.03, 0, {});
  EXPECT_GT(taken.first_held, 1);  // wheels slip
  EXPECT_LT(taken.furthest, 0.13);
  EXPECT_GT(taken.held, 30);
}

TEST(SettledWay, LetsNewSurfacesCorrectWheels) {
  EXPECT_EQ(drive(200, 0.0303, 0.03, {}).held, 0);
  EXPECT_EQ(drive(3, 0.03, 0, {}).held, 0);
  EXPECT_GT(drive(200, 0.04, 0.03, {}).held, 0);
  EXPECT_EQ(drive(200, 0.04, 0.03, {}, 0.05).held, 0);  // these wheels say that they slip
}

TEST(SettledWay, GoesWithSettledSurfaces) {
  EXPECT_EQ(drive(200, 0.1, 0, settled_along({0, 1, 5})).held, 0);
  EXPECT_EQ(drive(200, 0.1, 0, settled_along({0})).held, 0);
  EXPECT_GT(drive(200, 0.1, 0, settled_along({1, 2, 3, 4, 5})).held, 30);  // a floor and a wall aside
}

TEST(SettledWay, IsWhereSettledSurfacesLead) {
  // New ones lead 0.2 m ahead, settled ones ask for 2 cm to the left.
  SettledPairs settled = settled_along({1});
  settled.gradient[1] = 0.02 * settled.information(1, 1);
  SettledWay way;
  const auto T_held = way.observe(wheels_ahead(0, 1e-3), ahead(0), led_to(ahead(0.2), settled));
  ASSERT_TRUE(T_held);
  EXPECT_NEAR(T_held->translation().x(), 0, 1e-9);
  EXPECT_NEAR(T_held->translation().y(), 0.02, 1e-4);
}

TEST(SettledWay, BelievesFeaturesFurther) {
  const auto held = [](double led, bool anchored) {
    SettledWay way;
    return way.observe(wheels_ahead(0, 1e-3), ahead(0), led_to(ahead(led), {}), anchored).has_value();
  };
  EXPECT_TRUE(held(0.5, false));
  EXPECT_FALSE(held(0.5, true));
  EXPECT_TRUE(held(1, true));
}

TEST(SettledWay, BeginsAnew) {
  SettledWay way;
  const auto led = [&] {
    return way.observe(wheels_ahead(0, 1e-3), ahead(0), led_to(ahead(0.06), {})).has_value();
  };
  EXPECT_FALSE(led());
  EXPECT_TRUE(led());
  EXPECT_FALSE(led());  // it is there then
  way.begin();
  EXPECT_FALSE(led());
}

}  // namespace
}  // namespace lcmslam
