#include <lcmslam/evaluation/trajectory_error.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/evaluation/path_samples.hpp"

namespace lcmslam {
namespace {

EvaluationSettings with(Alignment alignment) {
  EvaluationSettings settings;
  settings.alignment = alignment;
  return settings;
}

TEST(Statistics, KnownAnswers) {
  const ErrorStatistics s = statistics({4, 1, 3, 2});
  EXPECT_EQ(s.count, 4u);
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(30.0 / 4));
  EXPECT_DOUBLE_EQ(s.maximum, 4);
  EXPECT_DOUBLE_EQ(statistics({5, 1, 3}).median, 3);
  EXPECT_TRUE(std::isnan(statistics({}).rmse));
}

TEST(AbsoluteError, IsZeroForTheSamePathInAnotherWorld) {
  Random random(7);
  const Trajectory truth = testing::curved_path(300);
  for (int trial = 0; trial < 20; ++trial) {
    const Trajectory estimate = testing::moved(truth, testing::random_pose(random));
    for (const Alignment alignment : {Alignment::se3, Alignment::sim3, Alignment::first_pose}) {
      const TrajectoryReport report = evaluate(truth, estimate, with(alignment));
      EXPECT_LT(report.absolute.translation.maximum, 1e-9);
      EXPECT_LT(report.absolute.rotation.maximum, 1e-6);
      EXPECT_NEAR(report.alignment.scale, 1, 1e-9);
      EXPECT_EQ(report.matched_poses, 300u);
      EXPECT_DOUBLE_EQ(report.tracked_fraction, 1);
    }
  }
}

TEST(AbsoluteError, DoesNotChangeWithARigidMotionOfEitherWorld) {
  Random random(8);
  const Trajectory truth = testing::curved_path(300);
  const Trajectory estimate = testing::with_noise(truth, random, 0.05, 0.02);
  const TrajectoryReport reference = evaluate(truth, estimate);
  EXPECT_NEAR(reference.absolute.translation.rmse, 0.05 * std::sqrt(3), 0.01);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Isometry3d A = testing::random_pose(random), B = testing::random_pose(random);
    const TrajectoryReport report = evaluate(testing::moved(truth, A), testing::moved(estimate, B));
    EXPECT_NEAR(report.absolute.translation.rmse, reference.absolute.translation.rmse, 1e-9);
    EXPECT_NEAR(report.absolute.rotation.rmse, reference.absolute.rotation.rmse, 1e-9);
    EXPECT_NEAR(report.per_second.translation.rmse, reference.per_second.translation.rmse, 1e-9);
    EXPECT_NEAR(report.per_metre.rotation.rmse, reference.per_metre.rotation.rmse, 1e-9);
  }
}

TEST(AbsoluteError, ConstantOffsetIsSeenOnlyWithoutAlignment) {
  const Trajectory truth = testing::curved_path(100);
  Eigen::Isometry3d offset = Eigen::Isometry3d::Identity();
  offset.translation() << 3, 0, 4;
  const Trajectory estimate = testing::moved(truth, offset);
  const ErrorStatistics none = evaluate(truth, estimate, with(Alignment::none)).absolute.translation;
  for (const double value : {none.rmse, none.mean, none.median, none.maximum}) EXPECT_NEAR(value, 5, 1e-9);
  EXPECT_NEAR(evaluate(truth, estimate, with(Alignment::se2)).absolute.translation.rmse, 4, 1e-9)
      << "se2 leaves the height";
  EXPECT_NEAR(evaluate(truth, estimate, with(Alignment::se3)).absolute.translation.rmse, 0, 1e-9);
}

TEST(AbsoluteError, PlanarAlignmentFindsHeading) {
  const Trajectory truth = testing::curved_path(100);
  const TrajectoryReport report =
      evaluate(truth, testing::moved(truth, planar_pose(1, -2, 2.5)), with(Alignment::se2));
  EXPECT_LT(report.absolute.translation.maximum, 1e-9);
  EXPECT_NEAR(yaw(report.alignment.T_truth_estimate), -2.5, 1e-9);
}

TEST(AbsoluteError, ScaleIsFoundBySim3AndOnlyBySim3) {
  Random random(4);
  const Trajectory truth = testing::curved_path(200);
  Trajectory estimate = testing::moved(truth, testing::random_pose(random));
  for (StampedPose& pose : estimate) pose.T_world_body.translation() *= 0.4;
  const TrajectoryReport sim3 = evaluate(truth, estimate, with(Alignment::sim3));
  EXPECT_NEAR(sim3.alignment.scale, 2.5, 1e-9);
  EXPECT_LT(sim3.absolute.translation.maximum, 1e-9);
  EXPECT_LT(sim3.per_second.translation.maximum, 1e-9);
  EXPECT_GT(evaluate(truth, estimate, with(Alignment::se3)).absolute.translation.rmse, 0.1);
}

// Least squares: no small motion away from the alignment lowers the error.
TEST(AbsoluteError, AlignmentIsTheMinimum) {
  Random random(5);
  const Trajectory truth = testing::curved_path(150);
  const auto matches = associate(
      truth, testing::moved(testing::with_noise(truth, random, 0.1, 0.05), testing::random_pose(random)));
  const WorldAlignment best = find_alignment(matches, Alignment::se3);
  const double least = absolute_errors(align(matches, best)).translation.rmse;
  for (int trial = 0; trial < 200; ++trial) {
    Vector6d twist;
    for (int i = 0; i < 6; ++i) twist[i] = random.normal(0, 0.02);
    const WorldAlignment other{1, best.T_truth_estimate * se3_exp(twist)};
    EXPECT_GE(absolute_errors(align(matches, other)).translation.rmse, least);
  }
}

TEST(AbsoluteError, MirroredPathIsNotAlignedByAReflection) {
  const Trajectory truth = testing::curved_path(200);
  Trajectory mirrored = truth;
  for (StampedPose& pose : mirrored) pose.T_world_body.translation().z() *= -1;
  const TrajectoryReport report = evaluate(truth, mirrored);
  EXPECT_NEAR(report.alignment.T_truth_estimate.linear().determinant(), 1, 1e-9);
  EXPECT_GT(report.absolute.translation.rmse, 0.05);
}

TEST(AbsoluteError, StraightAndStandingPathsHaveAnAnswer) {
  Trajectory line(50), still(50);
  for (std::size_t i = 0; i < 50; ++i) {
    line[i].utime = still[i].utime = static_cast<Utime>(i) * 100'000;
    line[i].T_world_body.translation() << 0.1 * static_cast<double>(i), 0, 0;
  }
  const Eigen::Isometry3d T = planar_pose(1, 2, 0.7);
  EXPECT_LT(evaluate(line, testing::moved(line, T)).absolute.translation.maximum, 1e-9);
  EXPECT_LT(evaluate(still, testing::moved(still, T)).absolute.translation.maximum, 1e-9);
  EXPECT_EQ(evaluate(still, still).per_metre.translation.count, 0u);
  EXPECT_THROW(evaluate(line, still, with(Alignment::sim3)), std::invalid_argument);
}

TEST(RelativeError, OfAConstantDriftIsTheDrift) {
  // 1 m/s along x at 10 Hz; the estimate is 2 % short and turns 0.01 rad a second too much.
  Trajectory truth(101), estimate(101);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double t = 0.1 * static_cast<double>(i);
    truth[i].utime = estimate[i].utime = std::llround(t * 1e6);
    truth[i].T_world_body.translation().x() = t;
    Vector6d twist;
    twist << 0.98 * t, 0, 0, 0, 0, 0.01 * t;
    estimate[i].T_world_body = se3_exp(twist);
  }
  const TrajectoryReport report = evaluate(truth, estimate);
  Vector6d second;
  second << 0.98, 0, 0, 0, 0, 0.01;
  Eigen::Vector3d wanted = se3_exp(second).translation() - Eigen::Vector3d::UnitX();
  EXPECT_NEAR(report.per_second.translation.rmse, wanted.norm(), 1e-9);
  EXPECT_NEAR(report.per_second.rotation.median, 0.01, 1e-9);
  EXPECT_EQ(report.per_second.translation.count, 91u);
  EXPECT_NEAR(report.per_metre.translation.maximum, wanted.norm(), 1e-9);
  EXPECT_NEAR(report.per_frame.rotation.maximum, 0.001, 1e-9);
  EXPECT_EQ(report.per_frame.translation.count, 100u);
  EXPECT_NEAR(report.truth_length, 10, 1e-9);
}

TEST(RelativeError, LeavesOutStepsThatTheDataDoesNotHold) {
  Trajectory truth = testing::curved_path(90);  // 3 s
  truth.erase(truth.begin() + 30, truth.begin() + 60);
  const auto matches = associate(truth, truth);
  const PoseErrors errors = relative_errors(matches, 1, StepUnit::seconds);
  EXPECT_GT(errors.translation.count, 0u);
  EXPECT_LT(errors.translation.count, 10u) << "only steps across the gap that happen to last a second";
  EXPECT_EQ(relative_errors(matches, 100, StepUnit::metres).translation.count, 0u);
  EXPECT_THROW(relative_errors(matches, 0, StepUnit::frames), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
