#include <lcmslam/evaluation/trajectory_error.hpp>

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/evaluation/path_samples.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(Association, IsOneToOneAndPrefersTheNearest) {
  const auto at = [](std::initializer_list<Utime> stamps) {
    Trajectory t;
    for (const Utime stamp : stamps) t.push_back({stamp, planar_pose(static_cast<double>(stamp), 0, 0)});
    return t;
  };
  // 1010 is nearest to both 1009 and 1012: 1009 wins, 1012 has no other partner within 5 ms.
  EvaluationSettings settings;
  settings.max_time_difference = 0.005;
  const auto matches = associate(at({1'000'000, 1'010'000}), at({1'009'000, 1'012'000}), settings);
  ASSERT_EQ(matches.size(), 1u);
  EXPECT_EQ(matches[0].utime, 1'009'000);
  EXPECT_EQ(matches[0].T_world_truth.translation().x(), 1'010'000);
  // A pair exactly at the limit does not count (associate.py).
  EXPECT_THROW(associate(at({1'000'000}), at({1'005'000}), settings), std::invalid_argument);
}

TEST(Association, InterpolationRemovesTheErrorOfUnequalStamps) {
  const Trajectory truth = testing::curved_path(300);
  Trajectory estimate;
  for (const StampedPose& pose : truth) {
    const auto T = pose_at(truth, pose.utime + 15'000);
    if (T) estimate.push_back({pose.utime + 15'000, *T});
  }
  EvaluationSettings settings;
  EXPECT_GT(evaluate(truth, estimate, settings).absolute.rotation.rmse, 1e-3);
  settings.association = Association::interpolate_truth;
  const TrajectoryReport report = evaluate(truth, estimate, settings);
  EXPECT_LT(report.absolute.translation.rmse, 1e-9);
  EXPECT_EQ(report.matched_poses, estimate.size());
}

TEST(Association, ClockOffsetIsTakenAway) {
  const Trajectory truth = testing::curved_path(100);
  Trajectory late = truth;
  for (StampedPose& pose : late) pose.utime += 3'600'000'000;
  EXPECT_THROW(evaluate(truth, late), std::invalid_argument);
  EvaluationSettings settings;
  settings.clock_offset = -3600;
  EXPECT_LT(evaluate(truth, late, settings).absolute.translation.maximum, 1e-9);
}

TEST(Association, WithoutACommonTimeTheErrorShowsBothSpans) {
  const Trajectory truth = testing::curved_path(10);
  const Trajectory later = testing::curved_path(20, truth.back().utime + 60'000'000);
  try {
    evaluate(truth, later);
    FAIL() << "no error";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("truth (10 poses, 1305031102.000"),
                                    HasSubstr("estimate (20 poses"), HasSubstr("same clock")));
  }
  EXPECT_THROW(evaluate(truth, {}), std::invalid_argument);
  EXPECT_THROW(evaluate({}, truth), std::invalid_argument);
  EXPECT_THROW(find_alignment({}, Alignment::se3), std::invalid_argument);
}

TEST(Association, ReversedOrRepeatedStampsAreAnError) {
  const Trajectory truth = testing::curved_path(10);
  Trajectory reversed(truth.rbegin(), truth.rend());
  EXPECT_THROW(evaluate(truth, reversed), std::invalid_argument);
  EXPECT_THROW(evaluate(reversed, truth), std::invalid_argument);
  sort_trajectory(reversed);
  EXPECT_LT(evaluate(truth, reversed).absolute.translation.maximum, 1e-9);
  Trajectory repeated = truth;
  repeated[5].utime = repeated[4].utime;
  EXPECT_THROW(evaluate(truth, repeated), std::invalid_argument);
}

TEST(Association, TrackedFractionIsTheShareOfTime) {
  const Trajectory truth = testing::curved_path(1001);  // 33 s
  Trajectory estimate = truth;
  estimate.erase(estimate.begin() + 200, estimate.begin() + 700);
  const TrajectoryReport report = evaluate(truth, estimate);
  EXPECT_NEAR(report.tracked_fraction, (199.0 + 300) / 1000, 1e-9);
  EXPECT_EQ(report.matched_poses, 501u);
}

TEST(Association, TimeWithoutATruthIsNotHeldAgainstTheEstimate) {
  const Trajectory estimate = testing::curved_path(1001);
  Trajectory truth = estimate;
  truth.erase(truth.begin() + 200, truth.begin() + 700);
  EXPECT_DOUBLE_EQ(evaluate(truth, estimate).tracked_fraction, 1);
}

/// Every n-th of them.
Trajectory thinned(const Trajectory& path, std::size_t n) {
  Trajectory some;
  for (std::size_t i = 0; i < path.size(); i += n) some.push_back(path[i]);
  return some;
}

// Poses each two seconds, of the truth or of the estimate, are no gaps; half an estimate is half.
TEST(Association, TrackedFractionKnowsHowOftenPosesCome) {
  const Trajectory often = testing::curved_path(3001);  // 100 s
  const Trajectory seldom = thinned(often, 60);
  const Trajectory half(often.begin(), often.begin() + 1501), seldom_half = thinned(half, 60);
  EXPECT_NEAR(evaluate(seldom, often).tracked_fraction, 1, 1e-9);
  EXPECT_NEAR(evaluate(seldom, half).tracked_fraction, 0.5, 0.02);
  EXPECT_NEAR(evaluate(often, seldom).tracked_fraction, 1, 1e-9);
  EXPECT_NEAR(evaluate(often, seldom_half).tracked_fraction, 0.5, 0.02);
  EvaluationSettings alone;
  alone.alignment = Alignment::none;
  EXPECT_TRUE(std::isnan(evaluate({often.front()}, often, alone).tracked_fraction)) << "of no time at all";
}

}  // namespace
}  // namespace lcmslam
