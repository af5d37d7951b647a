#include <lcmslam/registration/stop_criterion.hpp>

#include <gtest/gtest.h>

#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();

TEST(StopCriterion, SmallStepsOrASettledError) {
  RegistrationSettings settings;
  settings.epsilon_translation = 0.01;
  settings.epsilon_rotation = 0.01;
  settings.epsilon_rms = 1e-3;
  const StopCriterion stop(settings);
  const auto step = [](double metres, double radians) { return se3_exp(twist(metres, 0, 0, radians, 0, 0)); };
  EXPECT_TRUE(stop.arrived(identity, step(0.005, 0.005), {1}));
  EXPECT_FALSE(stop.arrived(identity, step(0.02, 0.005), {1}));
  EXPECT_FALSE(stop.arrived(identity, step(0.005, 0.02), {1}));
  EXPECT_FALSE(stop.arrived(identity, step(1, 1), {1, 0.5}));
  EXPECT_TRUE(stop.arrived(identity, step(1, 1), {1, 0.5, 0.4995}));
}

}  // namespace
}  // namespace lcmslam
