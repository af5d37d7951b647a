#include <lcmslam/dense_mapper/registration_passes.hpp>

#include <gtest/gtest.h>

#include <lcmslam/registration/kd_tree_target.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

const Eigen::Isometry3d at_origin = Eigen::Isometry3d::Identity();

class Passes : public testing::Test {
 protected:
  /// Every n-th point of the room from there; the others are somewhere in the air.
  static Cloud seen_from(const Eigen::Isometry3d& T_world_robot, std::size_t n = 1) {
    Cloud cloud = transformed(room(0.03), T_world_robot.inverse());
    cloud.sigmas.assign(cloud.size(), 0.003f);
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (i % n != 0) cloud.points[i] += 10 * Eigen::Vector3f::UnitX();
    return cloud;
  }
  RegistrationPasses::Attempt run(const Cloud& cloud, const Eigen::Isometry3d& T_start,
                                  const Eigen::Isometry3d& T_expected, double sigma = 0.1) const {
    const Prior prior{T_expected, Matrix6d::Identity() / (sigma * sigma)};
    return passes_.run({frame_, cloud}, target_, T_start, prior, LastView(false, false, {}));
  }
  double error(const RegistrationPasses::Attempt& attempt, const Eigen::Isometry3d& truth) const {
    const Eigen::Isometry3d& T = attempt.registration.T_target_source;
    return distance_between(T, truth) + angle_between(T, truth);
  }

  const Cloud room_ = room();
  const KdTreeTarget target_{room_};
  const RegistrationPasses passes_{DenseMapperSettings()};
  DenseFrame frame_;
};

TEST_F(Passes, TracksFromAStartNearby) {
  const Eigen::Isometry3d truth = se3_exp(twist(0.06, -0.05, 0.02, 0.01, 0.02, 0.04));
  const auto attempt = run(seen_from(truth), at_origin, at_origin);
  EXPECT_EQ(attempt.status, MappingStatus::tracking);
  EXPECT_LT(error(attempt, truth), 0.005);
  EXPECT_GT(attempt.quality, 0.9);
}

// A third of the points lies on the map: enough to go on by, too little to be sure.
TEST_F(Passes, WhatHalfFitsIsDegradedWhereItIsExpectedAndLostElsewhere) {
  const auto expected = run(seen_from(at_origin, 3), at_origin, at_origin);
  EXPECT_EQ(expected.status, MappingStatus::degraded);
  EXPECT_LT(expected.quality, 0.4);
  const Eigen::Isometry3d elsewhere = se3_exp(twist(2, 1, 0, 0, 0, 1));
  const auto recovered = run(seen_from(at_origin, 3), at_origin, elsewhere);
  EXPECT_EQ(recovered.status, MappingStatus::lost);
  EXPECT_LT(error(recovered, at_origin), 0.01) << "the same registration";
}

TEST_F(Passes, WhatHardlyFitsIsLost) {
  EXPECT_EQ(run(seen_from(at_origin, 6), at_origin, at_origin).status, MappingStatus::lost);
}

// What was expected is no knowledge for a start far from it.
TEST_F(Passes, ARecoveryIsNotDrawnToWhatWasExpected) {
  const Eigen::Isometry3d elsewhere = se3_exp(twist(0.4, 0.2, 0, 0, 0, 0.1));
  const auto recovered = run(seen_from(at_origin), at_origin, elsewhere, 1e-4);
  EXPECT_EQ(recovered.status, MappingStatus::tracking);
  EXPECT_LT(error(recovered, at_origin), 0.005);
}

// A prior that is surer than the points holds them back, but little where smoothing has made them surer.
TEST_F(Passes, SmoothedPointsHoldAgainstAPriorAsTheirNoiseIsLeft) {
  const Eigen::Isometry3d expected = se3_exp(twist(0.01, 0.01, -0.01, 0, 0, 0));
  const double sigma = 0.0005;
  const double as_noisy = error(run(seen_from(at_origin), expected, expected, sigma), at_origin);
  EXPECT_GT(as_noisy, 0.01);
  frame_.noise_left = 0.2;
  const auto smoothed = run(seen_from(at_origin), expected, expected, sigma);
  EXPECT_EQ(smoothed.status, MappingStatus::tracking);
  EXPECT_LT(error(smoothed, at_origin), 0.4 * as_noisy);
}

// The cloud draws the pose farther away than the robot can have gone.
TEST_F(Passes, AResultBeyondAJumpIsLost) {
  DenseMapperSettings settings;
  settings.max_jump = 0.03;
  const Eigen::Isometry3d truth = se3_exp(twist(0.06, -0.05, 0.02, 0.01, 0.02, 0.04));
  const Prior prior{at_origin, 100 * Matrix6d::Identity()};
  const auto attempt = RegistrationPasses(settings).run({frame_, seen_from(truth)}, target_, at_origin, prior,
                                                        LastView(false, false, {}));
  EXPECT_LT(error(attempt, truth), 0.01);
  EXPECT_EQ(attempt.status, MappingStatus::lost);
}

}  // namespace
}  // namespace lcmslam
