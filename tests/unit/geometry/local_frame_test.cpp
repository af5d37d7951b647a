// A pose in two parts, of which one never jumps.

#include <lcmslam/geometry/local_frame.hpp>

#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

constexpr double sigma = 0.003;  // m, rad, of a step's odometry

Motion forward(double way, double turn) {
  Motion motion;
  motion.T_from_to = planar_pose(way, 0, turn);
  motion.covariance = sigma * sigma * Matrix6d::Identity();
  return motion;
}

class LocalFrameTest : public ::testing::Test {
 protected:
  /// How far the local pose went beside the odometry, in one step.
  double advance(const Eigen::Isometry3d& T_map_robot, const Motion& motion) {
    const Eigen::Isometry3d before = frame_.T_local_robot();
    frame_.advance(T_map_robot, motion);
    EXPECT_TRUE((frame_.T_map_local() * frame_.T_local_robot()).isApprox(T_map_robot, 1e-9));
    return se3_log(motion.T_from_to.inverse() * before.inverse() * frame_.T_local_robot()).norm();
  }
  LocalFrame frame_;
};

TEST_F(LocalFrameTest, BeginsInTheMap) {
  advance(planar_pose(3, 4, 0.5), forward(0, 0));
  EXPECT_TRUE(frame_.T_local_robot().isApprox(Eigen::Isometry3d::Identity(), 1e-12));
  EXPECT_TRUE(frame_.T_map_local().isApprox(planar_pose(3, 4, 0.5), 1e-12));
}

// What the mapper sees better than the odometry is the local pose's, too.
TEST_F(LocalFrameTest, GoesWithTheMapperAsFarAsTheOdometryMayErr) {
  Random random(1);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  advance(T, forward(0, 0));
  for (int i = 0; i < 200; ++i) {
    const Motion odometry = forward(0.05, 0.02);
    Vector6d error = Vector6d::Zero();
    for (const int k : {0, 1, 5}) error(k) = sigma * random.uniform(-1, 1);
    T = T * odometry.T_from_to * se3_exp(error);
    advance(T, odometry);
  }
  EXPECT_TRUE(frame_.T_map_local().isApprox(Eigen::Isometry3d::Identity(), 1e-9));
}

TEST_F(LocalFrameTest, LeavesJumpsToTheCorrection) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  advance(T, forward(0, 0));
  const Motion odometry = forward(0.05, 0.02);
  T = planar_pose(0.1, -0.2, 0.05) * T * odometry.T_from_to;  // the map was bent
  EXPECT_LT(advance(T, odometry), 3.01 * sigma);
  EXPECT_NEAR(frame_.T_map_local().translation().norm(), std::hypot(0.1, 0.2), 4 * sigma);
  for (int i = 0; i < 10; ++i) {  // and nothing comes after it
    T = T * odometry.T_from_to;
    EXPECT_LT(advance(T, odometry), 1e-9);
  }
}

TEST_F(LocalFrameTest, GoesOnInAnotherMap) {
  advance(Eigen::Isometry3d::Identity(), forward(0, 0));
  advance(planar_pose(1, 0, 0), forward(1, 0));
  frame_.change_map(Eigen::Isometry3d::Identity());
  EXPECT_TRUE(frame_.T_local_robot().isApprox(planar_pose(1, 0, 0), 1e-9));
  EXPECT_LT(advance(planar_pose(0.05, 0, 0), forward(0.05, 0)), 1e-9);
}

}  // namespace
}  // namespace lcmslam
