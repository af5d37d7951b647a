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

// Of turning and moving sideways a camera sees much the same: how well odometry knows the one decides what is
// seen of the other. A noise of every step that hides it costs half of the accuracy.
TEST(MotionModel, OdometryThatKnowsItsErrorIsBelieved) {
  Motion step;  // of a differential base in a tenth of a second
  step.T_from_to.translation().x() = 0.045;
  step.covariance.diagonal() << 7e-6, 1.8e-7, 1e-8, 1e-8, 1e-8, 1e-5;
  const Matrix6d prior = motion_prior(step, FastSlamSettings()).covariance;
  for (const int axis : {0, 1}) {
    EXPECT_GE(prior(axis, axis), step.covariance(axis, axis));
    EXPECT_LT(prior(axis, axis), 2 * step.covariance(axis, axis)) << "axis " << axis;
  }
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

constexpr Utime frame_time = 33'000;  // us

Motion stated(double way, double way_sigma, double turn_sigma) {
  Motion motion;
  motion.T_from_to.translation().x() = way;
  motion.covariance.diagonal().head<3>().setConstant(way_sigma * way_sigma);
  motion.covariance.diagonal().tail<3>().setConstant(turn_sigma * turn_sigma);
  return motion;
}

TEST(UnknownMotion, GrowsWithTheTimeAndNotWithItsRoot) {
  const FastSlamSettings settings;
  UnknownMotion unknown(settings);
  unknown.prior(Motion(), 0);
  Matrix6d sum = Matrix6d::Zero();
  for (int i = 1; i <= 60; ++i) {
    const Motion prior = unknown.prior(stated(0, 10, 10), i * frame_time);
    EXPECT_TRUE(prior.T_from_to.isApprox(Eigen::Isometry3d::Identity()));
    sum += prior.covariance - motion_prior(Motion(), settings).covariance;
    EXPECT_EQ(unknown.lost(), 1e-6 * i * frame_time > settings.lost_after) << i;
  }
  EXPECT_TRUE(sum.isApprox(unknown_motion(60 * frame_time).covariance, 1e-9));
  unknown.end();
  EXPECT_FALSE(unknown.lost());
}

TEST(UnknownMotion, AnOdometryThatKnowsSomethingIsBelieved) {
  const FastSlamSettings settings;
  UnknownMotion unknown(settings);
  Utime now = 0;
  const auto believed = [&](const Motion& motion) {
    unknown.end();
    unknown.prior(Motion(), now += frame_time);
    return unknown.prior(motion, now += frame_time)
        .covariance.isApprox(motion_prior(motion, settings).covariance);
  };
  EXPECT_TRUE(believed(stated(0, 0.003, 0.003)));
  EXPECT_TRUE(believed(stated(0, 1, 0.003)));  // it turned so
  EXPECT_TRUE(believed(stated(0, 0.003, 1)));
  EXPECT_TRUE(believed(stated(2, 1, 1)));  // faster than we took it to be, but it moved
  EXPECT_FALSE(believed(stated(0, 1, 1)));
  EXPECT_FALSE(believed(stated(std::nan(""), 0.003, 0.003)));
}

// Its turn may be any by now, so that a visual odometry in the dark adds no more error to it.
TEST(UnknownMotion, GoesOnUntilBothAreKnown) {
  UnknownMotion unknown(FastSlamSettings{});
  unknown.prior(Motion(), 0);
  unknown.prior(stated(0, 1, 1), 200'000);
  EXPECT_FALSE(unknown.lost());
  unknown.prior(stated(0, 1, 0.001), 300'000);
  EXPECT_TRUE(unknown.lost());
}

// A camera of three images a second, without odometry.
TEST(UnknownMotion, OneStepOfASlowCameraLeavesItNear) {
  UnknownMotion unknown(FastSlamSettings{});
  Utime now = 0;
  const auto after = [&](Utime step) {
    unknown.prior(unknown_motion(step), now += step);
    return unknown.whereabouts();
  };
  unknown.prior(Motion(), now);
  EXPECT_EQ(after(200'000), Whereabouts::predicted);
  unknown.end();
  EXPECT_EQ(after(330'000), Whereabouts::near);
  EXPECT_TRUE(unknown.lost()) << "if it recognises nothing";
  EXPECT_EQ(after(330'000), Whereabouts::anywhere);
  unknown.prior(Motion(), now += 330'000);
  EXPECT_EQ(unknown.whereabouts(), Whereabouts::anywhere) << "whatever is known of a later step";
  unknown.end();
  EXPECT_EQ(after(4'000'000), Whereabouts::anywhere) << "a gap";
}

// Nobody states more than what a minute brings.
TEST(UnknownMotion, WhoWasAwayForLongIsLost) {
  for (const Utime minutes : {1, 2, 60}) {
    UnknownMotion unknown(FastSlamSettings{});
    unknown.prior(Motion(), 0);
    unknown.prior(unknown_motion(60'000'000), minutes * 60'000'000);
    EXPECT_TRUE(unknown.lost()) << minutes;
  }
}

}  // namespace
}  // namespace lcmslam
