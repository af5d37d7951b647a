// Stamps that go back or stand still, and counters that begin anew.

#include <lcmslam/odometry/wheel_odometry.hpp>

#include <gtest/gtest.h>

#include "tests/unit/odometry/simulated_bases.hpp"

namespace lcmslam {
namespace {

using testing::Base;
using testing::expect_near;

TEST(WheelOdometry, StampsThatGoBackStartAnewAndRepeatedOnesGiveNothing) {
  Base base = testing::differential_base();
  WheelOdometry odometry;
  const Encoders start = base.encoders;
  odometry.update(base.encoders);
  testing::drive(base, {1, 0, 0.3}, 1);
  ASSERT_TRUE(odometry.update(base.encoders));
  EXPECT_FALSE(odometry.update(base.encoders));
  const auto again = odometry.update(start);
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->T_odom_robot.isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_EQ(again->covariance, Matrix6d::Zero());
  EXPECT_EQ(odometry.twist().vx, 0);
}

// Read in pairs and stamped when they are read, as a serial line gives them.
TEST(WheelOdometry, MessagesThatComeTogetherLoseNoWay) {
  Base base = testing::all_bases().front();
  const PlanarTwist twist{0.5, 0, 0.1};
  testing::steer(base, twist);
  WheelOdometry odometry, even;
  for (int i = 0; i <= 200; ++i) {
    if (i > 0) testing::drive(base, twist, 0.02);
    const Eigen::Isometry3d T_even = even.update(base.encoders)->T_odom_robot;
    Encoders together = base.encoders;
    together.utime = 1'000'000 + i / 2 * 40'000 + i % 2 * 80;
    expect_near(odometry.update(together)->T_odom_robot, T_even, 1e-9, base.name);
    if (i < 3) continue;
    EXPECT_NEAR(odometry.twist().vx, 0.5, 1e-6) << i;
    EXPECT_NEAR(odometry.twist().w, 0.1, 1e-6) << i;
  }
  EXPECT_EQ(odometry.restarts(), 0);
}

TEST(WheelOdometry, CountersThatStartAgainKeepThePose) {
  Base base = testing::differential_base();
  WheelOdometry odometry;
  odometry.update(base.encoders);
  testing::drive(base, {0.5, 0, 0}, 10);
  const MotionSample before = *odometry.update(base.encoders);
  for (Wheel& wheel : base.encoders.wheels) wheel.angle = 0;
  base.encoders.utime += 20'000;
  const MotionSample after = *odometry.update(base.encoders);
  EXPECT_EQ(odometry.restarts(), 1);
  expect_near(before.T_odom_robot, after.T_odom_robot, 1e-12, "restart");
  EXPECT_GT(after.covariance(0, 0), before.covariance(0, 0));
  testing::drive(base, {0.5, 0, 0}, 2);
  expect_near(odometry.update(base.encoders)->T_odom_robot, planar_pose(6, 0, 0), 1e-9, "goes on");
}

// An emergency stop switches the motor controllers off and on; their driver lives on.
TEST(WheelOdometry, CountersThatComeHomeAfterASilenceHaveBegunAnew) {
  for (const double silence : {0.1, 1.5}) {
    Base base = testing::all_bases().front();
    WheelOdometry odometry;
    odometry.update(base.encoders);
    MotionSample before;
    for (int i = 0; i < 60; ++i) {
      testing::drive(base, {0.5, 0, 0}, 0.02);
      before = *odometry.update(base.encoders);
    }
    Encoders anew = base.encoders;
    anew.utime += static_cast<Utime>(1e6 * silence);
    for (Wheel& wheel : anew.wheels) wheel.angle = 0.001;
    const MotionSample sample = *odometry.update(anew);
    const bool is_restart = silence > 0.3;
    EXPECT_EQ(odometry.restarts(), is_restart ? 1 : 0) << silence;
    if (!is_restart) continue;  // between two messages of a driver that speaks: it may have driven back
    EXPECT_TRUE(sample.T_odom_robot.isApprox(before.T_odom_robot, 1e-12));
    EXPECT_GT(sample.covariance(0, 0), before.covariance(0, 0) + 0.1);
  }
}

// What a driver counts that has started again is no motion, however much it looks like one; and what was
// driven meanwhile, nobody knows.
TEST(WheelOdometry, AnotherSenderCountsFromAnotherStart) {
  for (const Utime silence : {500'000, 1'500'000}) {
    Base base = testing::differential_base();
    base.encoders.sender = 7;
    WheelOdometry odometry;
    odometry.update(base.encoders);
    testing::drive(base, {0.5, 0, 0.1}, 8);
    const MotionSample before = *odometry.update(base.encoders);
    for (Wheel& wheel : base.encoders.wheels) wheel.angle = 0;
    base.encoders.utime += silence;
    base.encoders.sender = 8;
    const MotionSample after = *odometry.update(base.encoders);
    EXPECT_EQ(odometry.restarts(), 1);
    expect_near(before.T_odom_robot, after.T_odom_robot, 1e-12, "restart");
    const Matrix6d added = after.covariance - before.covariance;
    const double seconds = 1e-6 * static_cast<double>(silence);
    for (const auto& [axis, sigma] : {std::pair(0, 0.5), std::pair(1, 0.5), std::pair(5, 1.0)}) {
      EXPECT_GT(std::sqrt(added(axis, axis)), sigma * seconds) << axis;
      EXPECT_LT(std::sqrt(added(axis, axis)), 1.05 * sigma * seconds) << axis;
    }
    EXPECT_LT(added(2, 2), 1e-3) << "it stays on the ground";
  }
}

}  // namespace
}  // namespace lcmslam
