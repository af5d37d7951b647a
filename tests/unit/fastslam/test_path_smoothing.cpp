// When the path is smoothed beside the filter, what that costs, and what becomes of the steps meanwhile.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "fastslam/fastslam.hpp"
#include "unit/fastslam/planar_world.hpp"

namespace lcmslam {
namespace {

using synthetic::make_planar_drive;
using synthetic::PlanarDrive;
using synthetic::PlanarStep;

constexpr double kTimePerPose = 100e-6;  // s, that the solver has

FastSlamSettings settings_with(double share) {
  FastSlamSettings s;
  s.measurement_inflation = 1;
  s.translation_noise = s.rotation_noise = 1e-4;  // the odometry states its own
  s.translation_noise_per_m = s.rotation_noise_per_m = s.rotation_noise_per_rad = 0;
  s.rejuvenation_share = share;
  return s;
}

struct Smoothings {
  int count = 0;
  double time = 0;  // s, that the solver had
};

Smoothings count_smoothings(const PlanarDrive& drive, double share) {
  FastSlam slam(settings_with(share));
  Smoothings smoothings;
  int sights = 0;
  for (const PlanarStep& step : drive.steps) {
    if (slam.step(step.motion, step.frame).rejuvenated) {
      ++smoothings.count;
      smoothings.time += kTimePerPose * (1 + sights);
    }
    sights += !step.frame.features.empty();
  }
  return smoothings;
}

TEST(PathSmoothing, TakesItsShareOfTheTime) {
  const PlanarDrive drive = make_planar_drive({}, 1);
  const double duration =
      1e-6 * static_cast<double>(drive.steps.back().frame.utime - drive.steps.front().frame.utime);
  const double longest = kTimePerPose * static_cast<double>(drive.steps.size());
  int before = 0;
  for (const double share : {0.002, 0.01, 0.05}) {
    const Smoothings smoothings = count_smoothings(drive, share);
    EXPECT_GT(smoothings.count, before) << share;
    EXPECT_LE(smoothings.time, 2 * share * duration + 2 * longest) << share;  // twice: few lineages
    before = smoothings.count;
  }
}

// Nothing is in sight for half a minute, then what was there before comes back.
TEST(PathSmoothing, IsThereAtOnceAfterARest) {
  PlanarDrive drive = make_planar_drive({}, 2);
  constexpr std::size_t last_sight = 200, first_sight = 350;
  for (std::size_t i = last_sight + 1; i < first_sight; ++i) drive.steps[i].frame.features.clear();
  FastSlam slam(settings_with(0.002));
  std::set<std::size_t> drawn;
  for (std::size_t i = 0; i < drive.steps.size(); ++i)
    if (slam.step(drive.steps[i].motion, drive.steps[i].frame).rejuvenated) drawn.insert(i);
  const auto next = drawn.lower_bound(first_sight);
  ASSERT_NE(next, drawn.end());
  EXPECT_LE(*next, first_sight + 2);
}

struct Drawn {
  int count = 0;
  double error = 0;  // m, RMS of the pose right after it
};

// Ten times as many frames a second: the solver is at work for several of them, which are then gone through
// once more, with the landmarks that were new in them.
TEST(PathSmoothing, StepsMeanwhileAreGoneThroughOnceMore) {
  const PlanarDrive drive = make_planar_drive({}, 3);
  std::vector<double> rmse;
  for (const Utime faster : {1, 10}) {
    FastSlam slam(settings_with(1));
    Drawn drawn;
    double squares = 0;
    for (const PlanarStep& step : drive.steps) {
      FeatureFrame frame = step.frame;
      frame.utime /= faster;
      const StepResult result = slam.step(step.motion, frame);
      const double error = (result.T_world_robot.translation() - step.T_start_robot.translation()).norm();
      squares += error * error;
      if (!result.rejuvenated) continue;
      ++drawn.count;
      drawn.error += error * error;
      // No particle has a landmark where another one has none, or far from it.
      for (std::size_t slot = 0; slot < drive.beacons.size(); ++slot) {
        const auto* first = slam.particles()[0].map.find(slot);
        for (const Particle& particle : slam.particles()) {
          const auto* other = particle.map.find(slot);
          ASSERT_EQ(first == nullptr, other == nullptr);
          if (!first || !other) continue;
          EXPECT_LT((first->mean - other->mean).norm(), 1) << slot;
        }
      }
    }
    rmse.push_back(std::sqrt(squares / static_cast<double>(drive.steps.size())));
    EXPECT_GT(drawn.count, 20) << faster;
    EXPECT_LT(std::sqrt(drawn.error / drawn.count), 1.5 * rmse.back()) << faster;
    std::set<std::int64_t> known;
    for (const Landmark& landmark : slam.landmarks()) {
      EXPECT_LT((landmark.mean.head<2>() - drive.beacons[static_cast<std::size_t>(landmark.id)]).norm(), 0.3);
      EXPECT_TRUE(known.insert(landmark.id).second);
    }
    EXPECT_GT(known.size(), 8U);
  }
  EXPECT_LT(rmse[1], 1.5 * rmse[0] + 0.01);
}

}  // namespace
}  // namespace lcmslam
