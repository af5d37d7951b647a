#include <lcmslam/rgbd/depth_clock.hpp>

#include <gtest/gtest.h>

#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

TEST(DepthClock, FindsTheOffsetFromTurns) {
  for (const double offset : {-0.014, 0.0, 0.008}) {
    DepthClock clock({});
    Random random(3);
    for (int i = 0; i < 600; ++i) {
      const Eigen::Vector3d omega(0.5 * std::sin(0.1 * i), std::cos(0.07 * i), 0.3);  // rad/s
      const auto turned = [&](double seconds) {
        Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
        T.linear() = so3_exp(omega * seconds);
        return T;
      };
      const Eigen::Vector3d noise(random.normal(0, 0.01), random.normal(0, 0.01), random.normal(0, 0.01));
      const Eigen::Isometry3d T = se3_exp(twist(1, 2, 0, 0.4, 0.1 * i, 0));
      clock.add(T * se3_exp(twist(0, 0, 0, noise.x(), noise.y(), noise.z())),
                T * turned(offset - clock.offset()), omega);
    }
    EXPECT_NEAR(clock.offset(), offset, 3 * clock.sigma());
    EXPECT_LT(clock.sigma(), 0.0015);
  }
}

TEST(DepthClock, StaysWhereNothingTurnsAndIgnoresWhatIsNoClock) {
  DepthClock clock({});
  const Eigen::Isometry3d far = se3_exp(twist(0, 0, 0, 0, 0.5, 0));
  for (int i = 0; i < 100; ++i) {
    clock.add(Eigen::Isometry3d::Identity(), se3_exp(twist(0, 0, 0, 0, 0.01, 0)), Eigen::Vector3d::Zero());
    clock.add(Eigen::Isometry3d::Identity(), far, {0, 1, 0});
  }
  EXPECT_EQ(clock.offset(), 0);
  EXPECT_DOUBLE_EQ(clock.sigma(), DepthClockSettings().prior);
}

}  // namespace
}  // namespace lcmslam
