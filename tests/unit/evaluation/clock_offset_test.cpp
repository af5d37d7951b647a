#include <lcmslam/evaluation/clock_offset.hpp>

#include <gmock/gmock.h>

#include <iostream>

#include "tests/support/recordings.hpp"
#include "tests/unit/evaluation/path_samples.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

/// The same path, stamped by a clock that lags: offset + stamp gives the truth's time.
Trajectory lagging(Trajectory trajectory, double offset) {
  for (StampedPose& pose : trajectory) pose.utime -= std::llround(1e6 * offset);
  return trajectory;
}

TEST(ClockOffset, IsFoundToATenthOfAMillisecondWithoutNoise) {
  const Trajectory truth = testing::curved_path(600);
  for (const double offset : {-0.4321, -0.2, -0.0133, 0.0, 0.0004, 0.0275, 0.1, 0.48}) {
    const ClockOffset found = estimate_clock_offset(truth, lagging(truth, offset));
    EXPECT_NEAR(found.offset, offset, 2e-4);
    EXPECT_LT(found.ate, 5e-4);
    EXPECT_TRUE(found.determined);
    EXPECT_LE(found.low, found.offset);
    EXPECT_GE(found.high, found.offset);
  }
}

TEST(ClockOffset, IsFoundToAFewMillisecondsInNoiseAnotherWorldAndDrift) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    const Trajectory truth = testing::curved_path(900);
    const double offset = random.uniform(-0.4, 0.4);
    Trajectory estimate =
        testing::moved(testing::with_noise(truth, random, 0.01, 0.01), testing::random_pose(random));
    for (std::size_t i = 0; i < estimate.size(); ++i)  // 3 cm in all
      estimate[i].T_world_body.translation().x() += 3.3e-5 * static_cast<double>(i);
    const ClockOffset found = estimate_clock_offset(truth, lagging(estimate, offset));
    EXPECT_NEAR(found.offset, offset, 0.004) << "seed " << seed;
    EXPECT_TRUE(found.determined) << "seed " << seed;
    EXPECT_GT(found.ate_zero, found.ate) << "seed " << seed;
  }
}

TEST(ClockOffset, OfAMonocularPathIsFoundWithScale) {
  const Trajectory truth = testing::curved_path(600);
  Trajectory estimate = lagging(truth, 0.12);
  for (StampedPose& pose : estimate) pose.T_world_body.translation() *= 0.3;
  EvaluationSettings settings;
  settings.alignment = Alignment::sim3;
  EXPECT_NEAR(estimate_clock_offset(truth, estimate, settings).offset, 0.12, 2e-4);
}

TEST(ClockOffset, LowersTheErrorThatEvaluateReports) {
  const Trajectory truth = testing::curved_path(600);
  const Trajectory estimate = lagging(truth, 0.25);
  EvaluationSettings settings;
  const double without = evaluate(truth, estimate, settings).absolute.translation.rmse;
  settings.clock_offset = estimate_clock_offset(truth, estimate, settings).offset;
  EXPECT_LT(evaluate(truth, estimate, settings).absolute.translation.rmse, 0.05 * without);
}

TEST(ClockOffset, WithATruthInterruptedIsStillFound) {
  Trajectory truth = testing::curved_path(900);
  const Trajectory estimate = lagging(truth, 0.07);
  truth.erase(truth.begin() + 300, truth.begin() + 500);
  EXPECT_NEAR(estimate_clock_offset(truth, estimate).offset, 0.07, 2e-4);
}

// At constant speed on a line every offset fits: the alignment takes it away.
TEST(ClockOffset, OfAStraightPathIsCalledUndetermined) {
  Trajectory line(300);
  for (std::size_t i = 0; i < line.size(); ++i) {
    line[i].utime = static_cast<Utime>(i) * 33'000;
    line[i].T_world_body.translation().x() = 0.02 * static_cast<double>(i);
  }
  const ClockOffset found = estimate_clock_offset(line, lagging(line, 0.1));
  EXPECT_FALSE(found.determined);
  EXPECT_LT(found.low, -0.4);
  EXPECT_GT(found.high, 0.4);
}

TEST(ClockOffset, BeyondTheRangeIsCalledUndetermined) {
  const Trajectory truth = testing::curved_path(600);
  EXPECT_FALSE(estimate_clock_offset(truth, lagging(truth, 0.9)).determined);
}

TEST(ClockOffset, NeedsPosesWithATruthAllOverTheRange) {
  const Trajectory truth = testing::curved_path(32);  // 1.05 s: one or two poses lie 0.5 s inside
  try {
    estimate_clock_offset(truth, truth);
    FAIL() << "no error";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("at least 10"));
  }
  ClockOffsetSearch narrow;
  narrow.range = 0.1;
  EXPECT_NEAR(estimate_clock_offset(truth, lagging(truth, 0.05), {}, narrow).offset, 0.05, 1e-3);
  narrow.step = 0;
  EXPECT_THROW(estimate_clock_offset(truth, truth, {}, narrow), std::invalid_argument);
}

// The publishers of fr1/xyz stamp truth and images by clocks that agree to about 20 ms.
TEST(ClockOffset, OfARecordingIsSmallAndFoundAgainAfterAShift) {
  LCMSLAM_SKIP_WITHOUT("trajectories");
  const auto folder = recording_path("trajectories");
  const Trajectory truth = read_tum(folder / "freiburg1_xyz-groundtruth.txt");
  const Trajectory estimate = read_tum(folder / "freiburg1_xyz-rgbdslam.txt");
  const ClockOffset found = estimate_clock_offset(truth, estimate);
  std::cout << "fr1/xyz, RGBD-SLAM: " << 1e3 * found.offset << " ms (" << 1e3 * found.low << " to "
            << 1e3 * found.high << "), ATE " << found.ate_zero << " m without, " << found.ate << " m with\n";
  EXPECT_LT(std::abs(found.offset), 0.05);
  EXPECT_TRUE(found.determined);
  const ClockOffset again = estimate_clock_offset(truth, lagging(estimate, 0.2));
  EXPECT_NEAR(again.offset, found.offset + 0.2, 1e-3);
}

}  // namespace
}  // namespace lcmslam
