// When the path is smoothed beside the filter, what that costs, and what becomes of the steps meanwhile.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include <lcmslam/fastslam/fastslam.hpp>
#include <lcmslam/geometry/rigid_alignment.hpp>
#include "tests/unit/fastslam/planar_world.hpp"

namespace lcmslam {
namespace {

using synthetic::make_planar_drive;
using synthetic::PlanarDrive;
using synthetic::PlanarStep;

constexpr double time_per_pose = 100e-6;  // s, that the solver has

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
  int observed = 0;
  for (const PlanarStep& step : drive.steps) {
    if (slam.step(step.motion, step.frame).rejuvenated) {
      ++smoothings.count;
      smoothings.time += time_per_pose * (1 + observed);
    }
    observed += !step.frame.features.empty();
  }
  return smoothings;
}

TEST(PathSmoothing, TakesItsShareOfTheTime) {
  const PlanarDrive drive = make_planar_drive({}, 1);
  const double duration =
      1e-6 * static_cast<double>(drive.steps.back().frame.utime - drive.steps.front().frame.utime);
  const double longest = time_per_pose * static_cast<double>(drive.steps.size());
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

// More frames a second: the solver is at work for many of them, which are then gone through once more, with
// the landmarks that were new in them: some beacons are out of sight until late.
TEST(PathSmoothing, StepsMeanwhileAreGoneThroughOnceMore) {
  PlanarDrive drive = make_planar_drive({}, 3);
  for (std::size_t i = 0; i < drive.steps.size(); ++i) {
    auto& features = drive.steps[i].frame.features;
    const auto hidden = [&](const Feature& f) {
      return f.landmark_id % 2 == 0 && static_cast<int>(i) < 100 + 30 * f.landmark_id;
    };
    features.erase(std::remove_if(features.begin(), features.end(), hidden), features.end());
  }
  std::vector<double> rmse;
  for (const Utime faster : {1, 10, 50}) {
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
          EXPECT_EQ(first->mean.isZero(0), other->mean.isZero(0)) << slot;  // never set
          EXPECT_LT((first->mean - other->mean).norm(), 3) << slot;
        }
      }
    }
    rmse.push_back(std::sqrt(squares / static_cast<double>(drive.steps.size())));
    EXPECT_GE(drawn.count, 5) << faster;
    EXPECT_LT(std::sqrt(drawn.error / drawn.count), 1.5 * rmse.back()) << faster;
    std::set<std::int64_t> known;
    for (const Landmark& landmark : slam.landmarks()) {
      EXPECT_LT((landmark.mean.head<2>() - drive.beacons[static_cast<std::size_t>(landmark.id)]).norm(), 1);
      EXPECT_TRUE(known.insert(landmark.id).second);
    }
    EXPECT_GT(known.size(), 8U);
  }
  EXPECT_LT(rmse[1], 1.5 * rmse[0] + 0.01);
  EXPECT_LT(rmse[2], 1.5 * rmse[0] + 0.01);
}

// The robot comes back to its first beacon after a lap of bad odometry, and meets a second one while the path
// is smoothed. The particles are far apart then, but each has the second beacon where it was seen from it.
TEST(PathSmoothing, ALandmarkBornMeanwhileIsMadeAnew) {
  synthetic::PlanarWorldSettings world;
  world.translation_sigma = world.rotation_sigma = 0.03;
  PlanarDrive drive = make_planar_drive(world, 6);
  constexpr std::size_t lap = 210, out_of_sight = 60;
  ASSERT_GE(drive.steps[lap].frame.features.size(), 2u);
  const int first = drive.steps[lap].frame.features.front().landmark_id;
  const int second = drive.steps[lap].frame.features.back().landmark_id;
  FastSlam slam(settings_with(1));
  std::size_t i = 0;
  for (bool drawn = false; !drawn; ++i) {
    ASSERT_LT(i, lap + 40);
    FeatureFrame frame = drive.steps[i].frame;
    frame.utime /= 200;  // many steps while the solver works
    const auto hidden = [&](const Feature& f) {
      return f.landmark_id == first ? i >= out_of_sight && i < lap : f.landmark_id != second || i <= lap;
    };
    auto& features = frame.features;
    features.erase(std::remove_if(features.begin(), features.end(), hidden), features.end());
    drawn = slam.step(drive.steps[i].motion, frame).rejuvenated && i > lap;
  }
  const Eigen::Vector2d& beacon = drive.beacons[static_cast<std::size_t>(second)];
  const Eigen::Vector3d seen =
      drive.steps[i - 1].T_start_robot.inverse() * Eigen::Vector3d(beacon.x(), beacon.y(), 0);
  Eigen::Matrix3Xd positions(3, static_cast<Eigen::Index>(slam.particles().size()));
  for (Eigen::Index k = 0; k < positions.cols(); ++k) {
    const Particle& particle = slam.particles()[static_cast<std::size_t>(k)];
    positions.col(k) = particle.T_world_robot.translation();
    const auto* landmark = particle.map.find(1);  // the slot of the second one
    ASSERT_NE(landmark, nullptr);
    EXPECT_LT((particle.T_world_robot.inverse() * landmark->mean.cast<double>() - seen).norm(), 0.4);
  }
  const double spread = (positions.colwise() - positions.rowwise().mean()).colwise().norm().mean();
  EXPECT_GT(spread, 0.4);  // else it proves nothing
}

// A beacon is moved while the robot drives: its landmark dies, and lives again where the beacon is now, in
// the filter's map as in what is drawn from the smoothed path.
TEST(PathSmoothing, WhatDiesAndIsBornAgainIsSmoothedWhereItIs) {
  PlanarDrive drive = make_planar_drive({}, 4);
  constexpr std::size_t moved_at = 300;
  const Eigen::Vector2d shift(1.5, -1);
  int id = -1;
  for (std::size_t i = moved_at; i < drive.steps.size(); ++i)
    for (Feature& f : drive.steps[i].frame.features) {
      if (id < 0) id = f.landmark_id;
      if (f.landmark_id != id) continue;
      const Eigen::Isometry3d& T = drive.steps[i].T_start_robot;
      const double range = f.point.x(), bearing = f.point.y();
      const Eigen::Vector3d was =
          T * Eigen::Vector3d(range * std::cos(bearing), range * std::sin(bearing), 0);
      const Eigen::Vector3d p = T.inverse() * Eigen::Vector3d(was.x() + shift.x(), was.y() + shift.y(), 0);
      f.point = Eigen::Vector3d(p.norm(), std::atan2(p.y(), p.x()), 0).cast<float>();
    }
  ASSERT_GE(id, 0);
  FastSlam slam(settings_with(1));
  int removed = 0, drawn_after = 0;
  for (std::size_t i = 0; i < drive.steps.size(); ++i) {
    const StepResult result = slam.step(drive.steps[i].motion, drive.steps[i].frame);
    removed += result.removed;
    drawn_after += removed > 0 && result.rejuvenated;
  }
  EXPECT_GE(removed, 1);
  EXPECT_GE(drawn_after, 3);
  int found = 0;
  for (const Landmark& landmark : slam.landmarks()) {
    if (landmark.id != id) continue;
    ++found;
    const Eigen::Vector2d now = drive.beacons[static_cast<std::size_t>(id)] + shift;
    EXPECT_LT((landmark.mean.head<2>() - now).norm(), 0.3);
  }
  EXPECT_EQ(found, 1);
}

// m, after the best fit: where the world lies is the filter's, whose first poses knew little.
double rmse(const std::vector<SmoothedPose>& path, const PlanarDrive& drive) {
  std::vector<Eigen::Vector3d> estimated, truth;
  for (const SmoothedPose& pose : path) {
    const auto i = static_cast<std::size_t>((pose.utime - drive.steps[0].frame.utime) / 200'000);
    estimated.emplace_back(pose.T_world_robot.translation());
    truth.emplace_back(drive.steps[i].T_start_robot.translation());
  }
  const Eigen::Isometry3d T = align_svd(estimated, truth).value();
  double squares = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) squares += (T * estimated[i] - truth[i]).squaredNorm();
  return std::sqrt(squares / static_cast<double>(truth.size()));
}

TEST(PathSmoothing, ASmoothedPathIsNearerToTheTruthThanTheFilterWas) {
  std::vector<double> smoothed, filtered;
  for (std::uint64_t seed = 1; seed <= 9; ++seed) {
    const PlanarDrive drive = make_planar_drive({}, seed);
    FastSlam slam(settings_with(1e-6));
    std::vector<SmoothedPose> at_their_time;
    for (std::size_t i = 0; i < 300; ++i) {
      const StepResult result = slam.step(drive.steps[i].motion, drive.steps[i].frame);
      at_their_time.push_back({drive.steps[i].frame.utime, result.T_world_robot});
    }
    smoothed.push_back(rmse(slam.smooth(), drive));
    filtered.push_back(rmse(at_their_time, drive));
  }
  std::nth_element(smoothed.begin(), smoothed.begin() + 4, smoothed.end());
  std::nth_element(filtered.begin(), filtered.begin() + 4, filtered.end());
  EXPECT_LT(smoothed[4], 0.03);
  EXPECT_LT(smoothed[4], 0.5 * filtered[4]);
}

// On request, beside the filter: told when it is done, once, and not after a newer path was told.
TEST(PathSmoothing, OnRequestIsToldOnce) {
  const PlanarDrive drive = make_planar_drive({}, 5);
  FastSlam slam(settings_with(1e-6));
  std::size_t told = 0;
  for (std::size_t i = 0; i < 400; ++i) {
    slam.step(drive.steps[i].motion, drive.steps[i].frame);
    const auto path = slam.take_smoothed();
    if (i == 300) {
      EXPECT_TRUE(slam.begin_smoothing());
    }
    if (path.empty()) continue;
    ++told;
    EXPECT_EQ(i, 301u);  // 30 ms later: with the next frame
    EXPECT_GT(path.size(), 250u);
    EXPECT_LT(rmse(path, drive), 0.05);
  }
  EXPECT_EQ(told, 1u);

  EXPECT_TRUE(slam.begin_smoothing());
  const auto newer = slam.smooth();
  EXPECT_EQ(newer.back().utime, drive.steps[399].frame.utime);
  slam.step(drive.steps[400].motion, drive.steps[400].frame);
  EXPECT_TRUE(slam.take_smoothed().empty());
}

}  // namespace
}  // namespace lcmslam
