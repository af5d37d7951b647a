// How well a motion is known before anything is observed.

#include <lcmslam/fastslam/motion_model.hpp>

#include <gtest/gtest.h>

#include <cmath>

namespace lcmslam {
namespace {

TEST(MotionModel, VisualOdometryIsBelievedLess) {
  FastSlamSettings settings;
  settings.translation_noise = settings.rotation_noise = 1e-6;
  settings.translation_noise_per_m = settings.rotation_noise_per_m = settings.rotation_noise_per_rad = 0;
  Motion motion;
  motion.covariance = 1e-4 * Matrix6d::Identity();
  const Matrix6d wheels = motion_prior(motion, settings).covariance;
  motion.visual = true;
  const Matrix6d visual = motion_prior(motion, settings).covariance;
  EXPECT_NEAR(visual(0, 0) / wheels(0, 0), settings.visual_factor * settings.visual_factor, 1e-3);
}

TEST(MotionModel, PlanarPriorStaysInThePlaneAndBadMotionIsNoIdea) {
  FastSlamSettings settings;
  Motion motion;
  Vector6d twist;
  twist << 0.1, 0.02, 0.03, 0.1, -0.1, 0.2;
  motion.T_from_to = se3_exp(twist);
  const Motion prior = motion_prior(motion, settings);
  EXPECT_EQ(prior.T_from_to.translation().z(), 0);
  EXPECT_EQ(prior.T_from_to(2, 2), 1);
  EXPECT_NEAR(yaw(prior.T_from_to), yaw(motion.T_from_to), 1e-12);
  motion.T_from_to.translation().x() = std::nan("");
  EXPECT_FALSE(usable(motion));
  const Motion unknown = motion_prior(motion, settings);
  EXPECT_TRUE(unknown.T_from_to.isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_GE(unknown.covariance(0, 0), 0.25);
}

// 0.5 m and 1 rad a second.
TEST(MotionModel, WithoutOdometryItGrowsWithTheTime) {
  const Motion motion = unknown_motion(2'000'000);
  EXPECT_TRUE(motion.T_from_to.isApprox(Eigen::Isometry3d::Identity()));
  Matrix6d expected = Matrix6d::Zero();
  expected.diagonal() << 1, 1, 1, 4, 4, 4;
  EXPECT_TRUE(motion.covariance.isApprox(expected, 1e-12));
  EXPECT_TRUE(usable(motion));
}

}  // namespace
}  // namespace lcmslam
