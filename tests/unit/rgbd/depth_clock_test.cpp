#include <lcmslam/rgbd/depth_clock.hpp>

#include <gtest/gtest.h>

#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

constexpr double frames_alike = 9;

/// After 20 s of turns about all axes, in which orientations differ by `noise` (rad).
DepthClock learned(double offset, double noise, std::uint64_t seed) {
  DepthClockSettings settings;
  settings.prior = 0.01;
  settings.frames_alike = frames_alike;
  DepthClock clock(settings);
  Random random(seed);
  for (int i = 0; i < 600; ++i) {
    const Eigen::Vector3d omega(0.5 * std::sin(0.1 * i), std::cos(0.07 * i), 0.3);  // rad/s
    const auto turned = [&](double seconds) {
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.linear() = so3_exp(omega * seconds);
      return T;
    };
    const Eigen::Isometry3d T = se3_exp(twist(1, 2, 0, 0.4, 0.1 * i, 0));
    const double x = random.normal(0, noise), y = random.normal(0, noise), z = random.normal(0, noise);
    clock.add(T * se3_exp(twist(0, 0, 0, x, y, z)), T * turned(offset - clock.offset()), omega,
              clock.offset());
  }
  return clock;
}

TEST(DepthClock, FindsTheOffsetFromTurns) {
  for (const double offset : {-0.014, 0.0, 0.008}) {
    const DepthClock clock = learned(offset, 0.01, 3);
    EXPECT_NEAR(clock.offset(), offset, 3 * clock.sigma());
    EXPECT_LT(clock.sigma(), 0.0015);
  }
}

// Clouds of images that are of one moment by their stamps are not moved in time, whatever was learned.
TEST(DepthClock, LearnsFromCloudsThatWereNotMoved) {
  for (const double offset : {0.0, 0.0003, -0.0008}) {
    DepthClock clock({});
    Random random(1);
    for (int i = 0; i < 5000; ++i) {
      const double omega = i / 200 % 2 == 0 ? 1 : -1;  // rad/s
      const double noise = random.normal(0, 0.003);
      clock.add(Eigen::Isometry3d::Identity(), planar_pose(0, 0, omega * offset + noise), {0, 0, omega}, 0);
    }
    EXPECT_NEAR(clock.offset(), offset, 2 * clock.sigma());
    EXPECT_LT(clock.sigma(), 2e-4);
  }
}

// Nine frames count as one, so sigma is three times what these independent ones err by.
TEST(DepthClock, KnowsHowWellItKnowsTheOffset) {
  const double alike = std::sqrt(frames_alike);
  for (const double noise : {0.005, 0.01, 0.025}) {
    double squares = 0;
    constexpr int seeds = 100;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      const DepthClock clock = learned(0.004, noise, seed);
      squares += std::pow((clock.offset() - 0.004) / clock.sigma(), 2) / seeds;
    }
    // 100 chi squares of 1: 14 %; the prior pulls by some hundredths of a sigma.
    EXPECT_NEAR(alike * std::sqrt(squares), 1, 0.2) << noise;
  }
}

TEST(DepthClock, StaysWhereNothingTurnsAndIgnoresWhatIsNoClock) {
  DepthClock clock({});
  const Eigen::Isometry3d far = se3_exp(twist(0, 0, 0, 0, 0.5, 0));
  for (int i = 0; i < 100; ++i) {
    clock.add(Eigen::Isometry3d::Identity(), se3_exp(twist(0, 0, 0, 0, 0.01, 0)), Eigen::Vector3d::Zero(), 0);
    clock.add(Eigen::Isometry3d::Identity(), far, {0, 1, 0}, 0);
  }
  EXPECT_EQ(clock.offset(), 0);
  EXPECT_DOUBLE_EQ(clock.sigma(), DepthClockSettings().prior);
}

}  // namespace
}  // namespace lcmslam
