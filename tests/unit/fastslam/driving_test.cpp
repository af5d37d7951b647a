// Laps in a world that deceives: how near the filter stays to the truth.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>

#include <lcmslam/fastslam/fastslam.hpp>
#include "tests/unit/fastslam/synthetic_world.hpp"

namespace lcmslam {
namespace {

using synthetic::Drive;
using synthetic::make_drive;
using synthetic::WorldSettings;

struct Score {
  double ate = 0, odometry_ate = 0;  // m, root mean square, no alignment: both start at the truth
  double nees = 0;                   // mean of the planar error's squared Mahalanobis distance
  int slips = 0, untracked = 0, wrong = 0, accepted = 0;
};

Score run(const FastSlamSettings& settings, const Drive& drive) {
  FastSlam slam(settings);
  Score score;
  for (const auto& step : drive.steps) {
    const StepResult r = slam.step(step.motion, step.frame);
    const Eigen::Isometry3d error = r.T_world_robot.inverse() * step.T_start_robot;
    score.ate += error.translation().squaredNorm();
    score.odometry_ate += (step.T_start_odometry.inverse() * step.T_start_robot).translation().squaredNorm();
    const Vector6d xi = se3_log(error);
    const Eigen::Vector3d planar(xi(0), xi(1), xi(5));
    Eigen::Matrix3d P;
    const int rows[] = {0, 1, 5};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) P(i, j) = r.covariance(rows[i], rows[j]);
    score.nees += planar.dot(P.inverse() * planar);
    score.slips += r.slipped;
    score.untracked += r.status != TrackStatus::tracking;
    for (const auto& observation : r.observations) {
      score.accepted += observation.accepted;
      score.wrong += observation.accepted && step.truth[static_cast<std::size_t>(observation.feature)] < 0;
    }
  }
  const double n = static_cast<double>(drive.steps.size());
  score.ate = std::sqrt(score.ate / n);
  score.odometry_ate = std::sqrt(score.odometry_ate / n);
  score.nees /= n;
  return score;
}

struct Variant {
  const char* name;
  FastSlamSettings settings;
  bool full_motion;
  double bar;  // m
};

std::vector<Variant> variants() {
  FastSlamSettings modern, version1, free6;
  version1.proposal = ProposalKind::motion;
  free6.planar = false;
  return {{"planar_2_0", modern, false, 0.03},
          {"planar_1_0", version1, false, 0.05},
          {"free6_2_0", free6, true, 0.05}};
}

class Driving : public testing::TestWithParam<Variant> {};

// 17 m of laps: 2 % scale and 3 % rotation error, slips that the stated covariance excludes, 7 % wrong
// descriptors, 10 % clutter, a systematic range error.
TEST_P(Driving, StaysNearTheTruth) {
  double nees = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    WorldSettings world;
    world.full_motion = GetParam().full_motion;
    FastSlamSettings settings = GetParam().settings;
    settings.seed = seed;
    const Score score = run(settings, make_drive(world, seed));
    std::cout << GetParam().name << " seed " << seed << ": ATE " << score.ate << " m, odometry "
              << score.odometry_ate << " m, NEES " << score.nees << " (3 expected), slips noticed "
              << score.slips << "\n";
    EXPECT_LT(score.ate, GetParam().bar);
    EXPECT_LT(score.ate, 0.25 * score.odometry_ate);
    EXPECT_GE(score.slips, 1);
    EXPECT_LE(score.untracked, 2);  // the first step, and hardly ever later
    EXPECT_LT(score.wrong, 0.01 * score.accepted);
    EXPECT_LT(score.nees, 30);
    nees += score.nees / 3;
  }
  EXPECT_GT(nees, 0.3);  // not far too careful,
  EXPECT_LT(nees, 6);    // nor overconfident: twice the expected
}

INSTANTIATE_TEST_SUITE_P(Variants, Driving, testing::ValuesIn(variants()),
                         [](const auto& variant) { return std::string(variant.param.name); });

// The floor rises and falls by 12 cm, at most 8 degrees steep, twice a lap, and nobody has said so.
// One landmark tells two of three numbers: what it leaves open after a slip is known as it was before.
TEST(FastSlam, FewLandmarksPutASlipRightWithoutLosingTheRest) {
  FastSlamSettings settings;
  settings.maximum_observations = 1;
  FastSlam slam(settings);
  double largest = 0;
  int corrected = 0;
  for (const auto& step : make_drive(WorldSettings(), 1).steps) {
    const StepResult r = slam.step(step.motion, step.frame);
    ASSERT_TRUE(r.covariance.allFinite());
    largest = std::max(largest, r.covariance.diagonal().maxCoeff());
    corrected += r.slipped ? 1 : 0;
  }
  EXPECT_GE(corrected, 1);
  EXPECT_LT(std::sqrt(largest), 1);
}

TEST(FastSlam, OnWheelsFindsOutThatTheFloorIsNotFlat) {
  for (std::uint64_t seed = 11; seed <= 12; ++seed) {
    WorldSettings world;
    world.frames = 240;
    FastSlamSettings settings;
    settings.seed = seed;
    world.ramp = 0.12;
    const Drive drive = make_drive(world, seed);
    FastSlam slam(settings);
    bool steep_seen = false;
    for (const auto& step : drive.steps) {
      const StepResult r = slam.step(step.motion, step.frame);
      const bool steep = off_ground(step.T_start_robot).tail<2>().norm() > 0.1;
      if (steep) {
        EXPECT_EQ(r.floor, Floor::free) << step.frame.seq;
      }
      steep_seen = steep_seen || steep;
    }
    EXPECT_TRUE(steep_seen);
  }
}

TEST(FastSlam, OnAFlatFloorStaysOnIt) {
  WorldSettings world;
  world.frames = 150;
  for (std::uint64_t seed = 11; seed <= 13; ++seed) {
    FastSlam slam({});
    for (const auto& step : make_drive(world, seed).steps)
      EXPECT_EQ(slam.step(step.motion, step.frame).floor, Floor::plane) << step.frame.seq;
  }
}

// Rows that are read one after the other, exposures, depths with a clock of their own: what moves fast stands
// at a wrong place, the near more than the far.
TEST(FastSlam, FeaturesWhoseMomentsAreUncertainMisleadLessWhereThatIsTold) {
  double told = 0, untold = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    WorldSettings world;
    world.frames = 150;
    world.timing = 0.03;
    const Drive drive = make_drive(world, seed);
    FastSlamSettings settings;
    settings.seed = seed;
    settings.timing_sigma = world.timing;
    told += run(settings, drive).ate / 6;
    settings.timing_sigma = 0;
    untold += run(settings, drive).ate / 6;
  }
  std::cout << "ATE " << told << " m, untold " << untold << " m\n";
  EXPECT_LT(told, 0.85 * untold);
}

TEST(FastSlam, ThesisPresetBeatsItsOdometry) {
  std::vector<double> ratios;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    FastSlamSettings settings = thesis_preset();
    settings.seed = seed;
    const Score score = run(settings, make_drive(WorldSettings(), seed));
    std::cout << "thesis seed " << seed << ": ATE " << score.ate << " m, odometry " << score.odometry_ate
              << " m\n";
    ratios.push_back(score.ate / score.odometry_ate);
  }
  std::sort(ratios.begin(), ratios.end());
  EXPECT_LT(ratios[2], 0.4) << "median";
  EXPECT_LT(ratios[4], 1.0) << "worst";
}

}  // namespace
}  // namespace lcmslam
