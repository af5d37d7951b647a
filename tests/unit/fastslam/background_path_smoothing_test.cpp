// When smoothing beside the filter begins and ends, and what is taken over.

#include <lcmslam/fastslam/smoothing/background_path_smoothing.hpp>

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/fastslam/planar_world.hpp"

namespace lcmslam {
namespace {

constexpr std::size_t whole = 120;  // steps

// Steps as a filter would give them whose estimate drifts a little.
std::vector<StepRecord> make_steps(const FastSlamSettings& settings, std::size_t count = whole) {
  const synthetic::PlanarDrive drive = synthetic::make_planar_drive({}, 8);
  OdometryCalibration calibration(settings);
  std::vector<StepRecord> steps;
  for (std::size_t i = 0; i < count; ++i) {
    const synthetic::PlanarStep& from = drive.steps[i];
    StepRecord step;
    step.utime = from.frame.utime;
    step.odometry = from.motion;
    calibration.begin(from.motion);
    step.calibration_jacobian = calibration.jacobian();
    step.measured = step.used = usable_features(from.frame, settings);
    step.T_world_robot = from.T_start_robot * planar_pose(1e-3 * static_cast<double>(i), 0, 0);
    step.covariance = 1e-4 * Matrix6d::Identity();
    steps.push_back(step);
  }
  return steps;
}

void add(const std::vector<StepRecord>& steps, std::size_t begin, std::size_t end,
         BackgroundPathSmoothing& smoothing) {
  for (std::size_t i = begin; i < end; ++i) smoothing.add(steps[i]);
}

// Poses that the path has: the first, and those with an observation.
std::int64_t poses(const std::vector<StepRecord>& steps, std::size_t end) {
  return 1 + std::count_if(steps.begin() + 1, steps.begin() + static_cast<std::ptrdiff_t>(end),
                           [](const StepRecord& step) { return !step.used.empty(); });
}

bool same(const SmoothedPath& a, const SmoothedPath& b) {
  if (a.cost != b.cost || a.samples.size() != b.samples.size() || a.path.size() != b.path.size())
    return false;
  for (std::size_t k = 0; k < a.samples.size(); ++k) {
    if (a.samples[k].T_world_robot.matrix() != b.samples[k].T_world_robot.matrix()) return false;
    if (a.samples[k].T_world_start.matrix() != b.samples[k].T_world_start.matrix()) return false;
  }
  for (std::size_t i = 0; i < a.path.size(); ++i)
    if (a.path[i].T_world_robot.matrix() != b.path[i].T_world_robot.matrix()) return false;
  return true;
}

TEST(BackgroundPathSmoothing, FitsPlanarMeasurementsOfKnownIdentityOnly) {
  std::vector<FeaturePoint> points(2);
  for (FeaturePoint& point : points) {
    point.landmark_id = 3;
    point.measurement.kind = MeasurementKind::range_bearing;
  }
  EXPECT_TRUE(BackgroundPathSmoothing::fits(points));
  EXPECT_TRUE(BackgroundPathSmoothing::fits({}));
  points[1].landmark_id = -1;
  EXPECT_FALSE(BackgroundPathSmoothing::fits(points));
  points[1].landmark_id = 4;
  points[1].measurement.kind = MeasurementKind::point;
  EXPECT_FALSE(BackgroundPathSmoothing::fits(points));
}

TEST(BackgroundPathSmoothing, IsDueATenthOfAMillisecondAPoseLater) {
  const FastSlamSettings settings;
  const auto steps = make_steps(settings);
  BackgroundPathSmoothing smoothing(settings);
  EXPECT_FALSE(smoothing.begin_on_request());  // nothing there
  add(steps, 0, whole, smoothing);
  EXPECT_TRUE(smoothing.begin_on_request());
  EXPECT_TRUE(smoothing.requested());
  const Utime due = steps[whole - 1].utime + 100 * poses(steps, whole);
  EXPECT_FALSE(smoothing.due(due - 1));
  EXPECT_TRUE(smoothing.due(due));
  const SmoothedPath result = smoothing.take_over();
  EXPECT_TRUE(result.requested);
  EXPECT_FALSE(smoothing.running());
  EXPECT_FALSE(smoothing.requested());
  EXPECT_EQ(static_cast<std::int64_t>(result.path.size()), poses(steps, whole));
  EXPECT_EQ(result.samples.size(), static_cast<std::size_t>(settings.particles));
}

// What comes while the solver runs changes nothing of its result, is given back in order, and is part of the
// next.
TEST(BackgroundPathSmoothing, StepsMeanwhileAreGivenBackAndCountLater) {
  const FastSlamSettings settings;
  const auto steps = make_steps(settings);
  constexpr std::size_t begun = 80;
  BackgroundPathSmoothing alone(settings), beside(settings), at_once(settings);
  add(steps, 0, begun, alone);
  const SmoothedPath early = alone.smooth();
  EXPECT_TRUE(early.since.empty());

  add(steps, 0, begun, beside);
  beside.begin_on_request();
  add(steps, begun, whole, beside);
  const SmoothedPath taken = beside.take_over();
  EXPECT_TRUE(same(early, taken));
  ASSERT_EQ(taken.since.size(), whole - begun);
  for (std::size_t i = begun; i < whole; ++i) EXPECT_EQ(taken.since[i - begun].utime, steps[i].utime);

  add(steps, begun, whole, alone);
  EXPECT_TRUE(same(alone.smooth(), beside.smooth())) << "the same steps, the same result, however they came";
}

// A landmark that died while the solver ran counts no more in the next path.
TEST(BackgroundPathSmoothing, ForgetsWhatDiedMeanwhile) {
  const FastSlamSettings settings;
  auto steps = make_steps(settings);
  const std::int32_t dead = steps[10].used.front().landmark_id;
  steps[85].forgotten.push_back(dead);
  for (std::size_t i = 85; i < whole; ++i)
    for (auto* points : {&steps[i].used, &steps[i].measured})
      points->erase(std::remove_if(points->begin(), points->end(),
                                   [&](const FeaturePoint& point) { return point.landmark_id == dead; }),
                    points->end());
  BackgroundPathSmoothing smoothing(settings);
  add(steps, 0, 80, smoothing);
  smoothing.begin_on_request();
  add(steps, 80, whole, smoothing);
  EXPECT_EQ(smoothing.take_over().samples.front().landmarks.count(dead), 1U);
  EXPECT_EQ(smoothing.smooth().samples.front().landmarks.count(dead), 0U);
}

// It needs a reason and its share of the time, the more urgently the fewer lineages there are.
TEST(BackgroundPathSmoothing, BeginsForAReasonWhenItHasRested) {
  FastSlamSettings settings;
  const auto steps = make_steps(settings);
  const auto begins = [&](double share, bool reunion, bool few) {
    settings.rejuvenation_share = share;
    BackgroundPathSmoothing smoothing(settings);
    add(steps, 0, 100, smoothing);
    smoothing.smooth();
    smoothing.add(steps[100]);  // 0.2 s later
    smoothing.begin_when_due(reunion, few);
    const bool begun = smoothing.running();
    if (begun) smoothing.take_over();
    return begun;
  };
  const double needed = 1e-4 * static_cast<double>(poses(steps, 101)) / 0.2;
  EXPECT_FALSE(begins(10 * needed, false, false));
  EXPECT_TRUE(begins(1.1 * needed, true, false));
  EXPECT_FALSE(begins(0.9 * needed, true, false));
  EXPECT_TRUE(begins(0.6 * needed, false, true));
  EXPECT_FALSE(begins(0.4 * needed, false, true));
}

// A reunion that came while it had to rest is not forgotten.
TEST(BackgroundPathSmoothing, RemembersAReunionUntilItBegins) {
  FastSlamSettings settings;
  settings.rejuvenation_share = 0.02;
  const auto steps = make_steps(settings);
  BackgroundPathSmoothing smoothing(settings);
  add(steps, 0, 100, smoothing);
  smoothing.smooth();
  smoothing.add(steps[100]);
  smoothing.begin_when_due(true, false);
  EXPECT_FALSE(smoothing.running());
  for (std::size_t i = 101; i < whole && !smoothing.running(); ++i) {
    smoothing.add(steps[i]);
    smoothing.begin_when_due(false, false);
  }
  EXPECT_TRUE(smoothing.running());
}

}  // namespace
}  // namespace lcmslam
