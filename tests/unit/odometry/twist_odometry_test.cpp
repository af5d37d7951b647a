#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include <lcmslam/odometry/twist_odometry.hpp>

namespace lcmslam {
namespace {

Twist twist_at(double seconds, double v, double w) {
  return {std::llround(1e6 * seconds), {v, 0, 0}, {0, 0, w}};
}

TEST(TwistOdometry, HoldsATwistUntilTheNext) {
  TwistOdometry odometry;
  const auto first = odometry.update(twist_at(1, 0.5, 0));
  ASSERT_TRUE(first);
  EXPECT_TRUE(first->T_odom_robot.isApprox(Eigen::Isometry3d::Identity()));
  const auto second = odometry.update(twist_at(1.8, 0, 1));
  EXPECT_NEAR(second->T_odom_robot.translation().x(), 0.4, 1e-9);
  const auto third = odometry.update(twist_at(2.3, 0, 0));
  EXPECT_NEAR(yaw(third->T_odom_robot), 0.5, 1e-9);
  EXPECT_NEAR(third->T_odom_robot.translation().x(), 0.4, 1e-9);
}

TEST(TwistOdometry, CurvesAreExactArcs) {
  TwistOdometry odometry;
  odometry.update(twist_at(0, 1, 1));
  const auto sample = odometry.update(twist_at(1, 0, 0));
  EXPECT_NEAR(sample->T_odom_robot.translation().x(), std::sin(1.0), 1e-9);
  EXPECT_NEAR(sample->T_odom_robot.translation().y(), 1 - std::cos(1.0), 1e-9);
}

TEST(TwistOdometry, CovarianceDoesNotDependOnHowOftenTwistsCome) {
  TwistOdometrySettings settings;
  settings.curve_noise = 0.05;
  TwistOdometry seldom(settings), often(settings);
  MotionSample a, b;
  for (int i = 0; i <= 2; ++i) a = *seldom.update(twist_at(0.5 * i, 0.4, 0.8));
  for (int i = 0; i <= 100; ++i) b = *often.update(twist_at(0.01 * i, 0.4, 0.8));
  EXPECT_TRUE(a.T_odom_robot.isApprox(b.T_odom_robot, 1e-9));
  EXPECT_TRUE(a.covariance.isApprox(b.covariance, 0.03));
  EXPECT_GT(b.covariance(0, 0), 0.05 * 0.05 * 0.8 * 0.9);
}

TEST(TwistOdometry, ADelayedBaseIsWhereItWasMeantToBeLater) {
  TwistOdometrySettings settings;
  settings.delay = 0.2;
  TwistOdometry odometry(settings);
  EXPECT_EQ(odometry.update(twist_at(1, 1, 0))->utime, 1'200'000);
  EXPECT_EQ(odometry.update(twist_at(2, 0, 0))->utime, 2'200'000);
}

TEST(TwistOdometry, SilenceIsNoMotionAndMuchDoubt) {
  TwistOdometrySettings settings;
  settings.timeout = 1;
  settings.max_speed = 2;
  TwistOdometry odometry(settings);
  odometry.update(twist_at(0, 0.5, 0));
  const auto sample = odometry.update(twist_at(3, 0.5, 0));
  EXPECT_NEAR(sample->T_odom_robot.translation().x(), 0.5, 1e-9);
  EXPECT_GT(sample->covariance(0, 0), 15);
}

TEST(TwistOdometry, ATwistWithoutASuccessorLeadsOnWhereTimeIsTold) {
  TwistOdometry odometry;
  EXPECT_FALSE(odometry.hold(1'000'000, 1'000'000)) << "before the first";
  odometry.update(twist_at(1, 0, 0));
  odometry.update(twist_at(1.1, 0.5, 0));
  EXPECT_FALSE(odometry.hold(1'150'000, 1'150'000)) << "a twist may be under way";
  const auto held = odometry.hold(1'500'000, 1'500'000);
  ASSERT_TRUE(held);
  EXPECT_EQ(held->utime, 1'500'000);
  EXPECT_NEAR(held->T_odom_robot.translation().x(), 0.2, 1e-9);
  EXPECT_FALSE(odometry.hold(1'500'000, 1'500'000)) << "told already";
  EXPECT_FALSE(odometry.update(twist_at(1.4, 0, 0))) << "late: a later pose is told already";
  const auto next = odometry.hold(1'600'000, 1'600'000);
  ASSERT_TRUE(next);
  EXPECT_NEAR(next->T_odom_robot.translation().x(), 0.15, 1e-9) << "from its own time on it counts";
  EXPECT_NEAR(odometry.update(twist_at(1.8, 0, 0))->T_odom_robot.translation().x(), 0.15, 1e-9);
}

// Who is asked so seldom that mappers go on without waiting tells what he knows.
TEST(TwistOdometry, ATwistIsHeldAtOnceWhereNobodyWaitsForTheNextTime) {
  TwistOdometry odometry;
  odometry.update(twist_at(1, 0.5, 0));
  odometry.update(twist_at(1.1, 0, 0));
  EXPECT_FALSE(odometry.hold(1'150'000, 1'250'000));
  const auto held = odometry.hold(1'150'000, 1'650'000);
  ASSERT_TRUE(held);
  EXPECT_EQ(held->utime, 1'150'000);
  EXPECT_NEAR(held->T_odom_robot.translation().x(), 0.05, 1e-9);
}

TEST(TwistOdometry, HeldOrFollowedATwistTellsTheSame) {
  TwistOdometry held, followed;
  for (TwistOdometry* odometry : {&held, &followed}) odometry->update(twist_at(0, 0.4, 0.8));
  const auto a = held.hold(500'000, 500'000);
  const auto b = followed.update(twist_at(0.5, 0, 0));
  ASSERT_TRUE(a);
  EXPECT_TRUE(a->T_odom_robot.isApprox(b->T_odom_robot, 1e-12));
  EXPECT_TRUE(a->covariance.isApprox(b->covariance, 1e-12));
}

TEST(TwistOdometry, AfterTimeoutDoubtIsToldAndThenNothing) {
  TwistOdometrySettings settings;
  settings.timeout = 1;
  settings.delay = 0.2;
  TwistOdometry odometry(settings);
  odometry.update(twist_at(0, 0.5, 0));
  EXPECT_TRUE(odometry.hold(1'200'000, 1'200'000));
  EXPECT_TRUE(odometry.holding(1'190'000));
  EXPECT_FALSE(odometry.holding(1'300'000));
  const auto doubtful = odometry.hold(2'200'000, 2'200'000);
  ASSERT_TRUE(doubtful);
  EXPECT_NEAR(doubtful->T_odom_robot.translation().x(), 0.5, 1e-9);
  EXPECT_GT(doubtful->covariance(0, 0), 3.9);
  EXPECT_FALSE(odometry.hold(4'200'000, 4'200'000));
}

TEST(TwistOdometry, RepeatedAndLoopingStamps) {
  TwistOdometry odometry;
  odometry.update(twist_at(1, 1, 0));
  EXPECT_FALSE(odometry.update(twist_at(1, 1, 0)));
  odometry.update(twist_at(2, 1, 0));
  EXPECT_TRUE(odometry.update(twist_at(0.5, 1, 0))->T_odom_robot.isApprox(Eigen::Isometry3d::Identity()));
}

TEST(TwistOdometry, WrongSettingsAreNamed) {
  TwistOdometrySettings settings;
  settings.curve_noise = -1;
  EXPECT_THAT([&] { TwistOdometry odometry(settings); },
              ::testing::ThrowsMessage<std::invalid_argument>(::testing::HasSubstr("curve_noise")));
  settings.curve_noise = 0;
  settings.delay = NAN;
  EXPECT_THAT([&] { TwistOdometry odometry(settings); },
              ::testing::ThrowsMessage<std::invalid_argument>(::testing::HasSubstr("delay")));
}

}  // namespace
}  // namespace lcmslam
