#include <lcmslam/odometry/external_odometry.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace lcmslam {
namespace {

constexpr Utime s = 1'000'000;  // us

Eigen::Isometry3d pose(double x, double y, double yaw) {
  return se3_exp((Vector6d() << x, y, 0, 0, 0, 0).finished()) *
         se3_exp((Vector6d() << 0, 0, 0, 0, 0, yaw).finished());
}

TEST(ExternalOdometry, PassesThePoseOn) {
  ExternalOdometry odometry;
  const MotionSample sample = odometry.update(1'500'000, pose(2, -1, 0.7));
  EXPECT_EQ(sample.utime, 1'500'000);
  EXPECT_EQ(sample.T_odom_robot.matrix(), pose(2, -1, 0.7).matrix());
  EXPECT_FALSE(sample.visual);
}

TEST(ExternalOdometry, VarianceGrowsWithTheWayAndTheTurn) {
  for (const auto& [T, way] : {std::pair(pose(0, 0, 0), 0.0), std::pair(pose(3, 4, 0), 5.0),
                               std::pair(pose(0, 0, 1.5), 0.3 * 1.5)}) {
    ExternalOdometry odometry;
    const Matrix6d covariance = odometry.update(1, T).covariance;
    EXPECT_TRUE(covariance.isApprox((1e-8 + 4e-4 * way) * Matrix6d::Identity(), 1e-9)) << covariance;
  }
}

// What a heading error does to a position grows with the distance from where it was made.
TEST(ExternalOdometry, TheIncrementIsWorthItsOwnStep) {
  ExternalOdometry odometry;
  MotionBuffer buffer;
  for (const auto& [utime, T] :
       {std::pair(1 * s, pose(0, 0, 0)), std::pair(2 * s, pose(1, 0.5, 0.4)),
        std::pair(3 * s, pose(1.4, 0.8, 0.4)), std::pair(4 * s, pose(1.4, 0.8, 0.9))})
    buffer.add(odometry.update(utime, T));
  const auto straight = buffer.between(2 * s, 3 * s);
  const auto turn = buffer.between(3 * s, 4 * s);
  ASSERT_TRUE(straight && turn);
  EXPECT_NEAR(straight->T_from_to.translation().norm(), 0.5, 1e-12);
  EXPECT_TRUE(straight->covariance.isApprox((1e-8 + 4e-4 * 0.5) * Matrix6d::Identity(), 1e-9));
  EXPECT_TRUE(turn->covariance.isApprox((1e-8 + 4e-4 * 0.3 * 0.5) * Matrix6d::Identity(), 1e-9));
}

TEST(ExternalOdometry, AHeadingErrorMovesWhatComesAfterIt) {
  ExternalOdometry odometry;
  odometry.update(1 * s, pose(0, 0, 0));
  odometry.update(2 * s, pose(0, 0, 2));
  const Matrix6d turned = odometry.update(3 * s, pose(0, 0, 2)).covariance;
  const Eigen::Isometry3d far = pose(0, 0, 2) * pose(10, 0, 0);
  const Matrix6d covariance = odometry.update(5 * s, far).covariance;
  // 10 m ahead, the lateral error is the turn's heading error times 10 m, besides both steps' own.
  EXPECT_NEAR(covariance(1, 1), turned(1, 1) + 100 * turned(5, 5) + 1e-8 + 4e-4 * 10, 1e-9);
  EXPECT_NEAR(covariance(0, 0), turned(0, 0) + 1e-8 + 4e-4 * 10, 1e-9);
}

// Whoever begins anew says nothing of the motion, and goes on where he was.
TEST(ExternalOdometry, ADriverThatBeginsAnewKeepsThePose) {
  const std::vector<std::pair<Utime, Eigen::Isometry3d>> begun_anew = {
      {3 * s, pose(0.01, 0, 0)},            // at its origin after a second of silence
      {2 * s + s / 50, pose(-3, 1, 0.4)}};  // a step that no robot makes
  for (const auto& [utime, T] : begun_anew) {
    ExternalOdometry odometry;
    odometry.update(1 * s, pose(3, 2, 0.5));
    const MotionSample before = odometry.update(2 * s, pose(4, 2, 0.7));
    const MotionSample after = odometry.update(utime, T);
    EXPECT_EQ(odometry.restarts(), 1);
    EXPECT_EQ(after.T_odom_robot.matrix(), before.T_odom_robot.matrix());
    const Matrix6d unseen = unknown_motion(utime - 2 * s).covariance;
    EXPECT_TRUE((after.covariance - before.covariance).isApprox(unseen, 1e-9)) << after.covariance;
    const Eigen::Isometry3d step = pose(0.3, 0.1, 0.2);
    const MotionSample on = odometry.update(utime + s, T * step);
    EXPECT_TRUE(on.T_odom_robot.isApprox(before.T_odom_robot * step, 1e-9));
    EXPECT_EQ(odometry.restarts(), 1);
  }
}

// A silence alone is none, and driving home neither.
TEST(ExternalOdometry, ADriverThatWasSilentTellsTheWay) {
  ExternalOdometry odometry;
  odometry.update(1 * s, pose(0.5, 0, 0));
  EXPECT_EQ(odometry.update(3 * s, pose(1.5, 0, 0)).T_odom_robot.matrix(), pose(1.5, 0, 0).matrix());
  for (int i = 1; i <= 30; ++i) odometry.update(3 * s + i * s / 10, pose(1.5 - 0.05 * i, 0, 0));
  EXPECT_EQ(odometry.restarts(), 0);
}

// Read in pairs and stamped when they are read, as a serial line gives them.
TEST(ExternalOdometry, MessagesThatComeTogetherLoseNoWay) {
  ExternalOdometry odometry;
  MotionSample sample;
  for (int i = 0; i <= 200; ++i)
    sample = odometry.update(s + i / 2 * 40'000 + i % 2 * 80, pose(0.01 * i, 0, 0));
  EXPECT_EQ(odometry.restarts(), 0);
  EXPECT_NEAR(sample.T_odom_robot.translation().x(), 2, 1e-9);
}

}  // namespace
}  // namespace lcmslam
