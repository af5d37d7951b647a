// The pose graph with 3-D landmarks: known answers, wrong matches, and what it makes of a drive.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include <lcmslam/fastslam/fastslam.hpp>
#include <lcmslam/fastslam/smoothing/map_smoother.hpp>
#include "tests/unit/fastslam/synthetic_world.hpp"

namespace lcmslam {
namespace {

struct Planted {
  std::vector<Eigen::Isometry3d> truth, estimated;
  std::vector<Eigen::Vector3d> points;
};

// A lap among points; the estimates wander off by centimetres.
Planted plant(bool planar, std::uint64_t seed, MapSmoother& smoother, double wrong = 0) {
  Random random(seed, 5);
  Planted world;
  for (int i = 0; i < 150; ++i)
    world.points.emplace_back(random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(0, 2));
  Eigen::Isometry3d T_error = Eigen::Isometry3d::Identity();
  Motion motion;
  for (int i = 0; i < 60; ++i) {
    const double t = 0.1 * i;
    Eigen::Isometry3d T = planar_pose(2 * std::sin(t), 2 - 2 * std::cos(t), t);
    Vector6d sway = Vector6d::Zero(), drift = Vector6d::Zero();
    if (!planar) sway << 0, 0, 0.2 * std::sin(2 * t), 0.2 * std::sin(3 * t), 0.1 * std::sin(t), 0;
    T = T * se3_exp(sway);
    for (int k = 0; i > 0 && k < 6; ++k)
      if (!planar || k < 2 || k == 5) drift(k) = (k < 3 ? 0.01 : 0.004) * random.normal();
    T_error = T_error * se3_exp(drift);
    if (i > 0) {
      motion.T_from_to = world.truth.back().inverse() * T;
      motion.covariance = 1e-4 * Matrix6d::Identity();
    }
    world.truth.push_back(T);
    world.estimated.push_back(T * T_error);
    std::vector<PointObservation> seen;
    for (std::size_t p = 0; p < world.points.size(); ++p) {
      const Eigen::Vector3d local = T.inverse() * world.points[p];
      if (local.x() < 0.3 || local.norm() > 4 || std::abs(local.y()) > local.x()) continue;
      PointObservation observation;
      observation.landmark = static_cast<std::int64_t>(p);
      if (random.uniform() < wrong) observation.landmark = static_cast<std::int64_t>(random.below(150));
      observation.measurement.value = local;
      observation.measurement.covariance = 1e-4 * Eigen::Matrix3d::Identity();
      seen.push_back(observation);
    }
    smoother.add(1'000'000 + i, world.estimated.back(), motion, seen);
  }
  return world;
}

class Planting : public ::testing::TestWithParam<bool> {};

TEST_P(Planting, ExactObservationsGiveTheExactPathAndMap) {
  FastSlamSettings settings;
  settings.planar = GetParam();
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    MapSmoother smoother(settings);
    const Planted world = plant(settings.planar, seed, smoother);
    ASSERT_EQ(smoother.keyframes(), world.truth.size());  // each moves on by more than a keyframe's way
    const auto result = smoother.solve();
    ASSERT_TRUE(result);
    EXPECT_LT(result->cost_after, 1e-3 * result->cost_before);
    double before = 0;
    for (std::size_t i = 0; i < world.truth.size(); ++i) {
      const Eigen::Isometry3d& T = result->path[i].T_world_robot;
      EXPECT_LT((T.translation() - world.truth[i].translation()).norm(), 2e-3) << "seed " << seed;
      before = std::max(before, (world.estimated[i].translation() - world.truth[i].translation()).norm());
    }
    EXPECT_GT(before, 0.05);
    for (const auto& [id, mean] : result->landmarks)
      EXPECT_LT((mean - world.points[static_cast<std::size_t>(id)]).norm(), 4e-3) << "seed " << seed;
    const Eigen::Isometry3d corrected = result->T_world_correction * world.estimated.back();
    EXPECT_LT((corrected.translation() - world.truth.back().translation()).norm(), 2e-3);
  }
}

TEST_P(Planting, WrongMatchesDoNotDeformIt) {
  FastSlamSettings settings;
  settings.planar = GetParam();
  MapSmoother smoother(settings);
  const Planted world = plant(settings.planar, 4, smoother, 0.05);
  const auto result = smoother.solve();
  ASSERT_TRUE(result);
  for (std::size_t i = 0; i < world.truth.size(); ++i)
    EXPECT_LT((result->path[i].T_world_robot.translation() - world.truth[i].translation()).norm(), 0.03);
}

INSTANTIATE_TEST_SUITE_P(Spaces, Planting, ::testing::Bool(),
                         [](const auto& p) { return p.param ? "planar" : "free6"; });

TEST(MapSmoother, StandingStillMakesNoKeyframes) {
  MapSmoother smoother(FastSlamSettings{});
  PointObservation observation;
  observation.measurement.value << 1, 0, 0;
  observation.measurement.covariance = 1e-4 * Eigen::Matrix3d::Identity();
  for (int i = 0; i < 100; ++i) smoother.add(i, Eigen::Isometry3d::Identity(), Motion(), {observation});
  EXPECT_EQ(smoother.keyframes(), 1U);
  EXPECT_FALSE(smoother.solve());
}

Motion exact_motion(const Eigen::Isometry3d& T_before, const Eigen::Isometry3d& T) {
  Motion motion;
  motion.T_from_to = T_before.inverse() * T;
  motion.covariance = 1e-6 * Matrix6d::Identity();
  return motion;
}

/// Of these points, those ahead within `reach` m.
std::vector<PointObservation> seen_from(const Eigen::Isometry3d& T, double reach,
                                        const std::vector<Eigen::Vector3d>& points) {
  std::vector<PointObservation> seen;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const Eigen::Vector3d local = T.inverse() * points[p];
    if (local.x() < 0.3 || local.norm() > reach) continue;
    seen.push_back({static_cast<std::int64_t>(p), {local, 1e-4 * Eigen::Matrix3d::Identity()}});
  }
  return seen;
}

// A robot that drives its lap again and again, with an odometry that drifts and is put right by the filter.
// `radius` m, `step` rad of the lap between poses; T_estimated = T exp(drift), which the observations
// contradict.
MapSmoother lapping(double radius, double step, int poses, Eigen::Isometry3d* T_last = nullptr) {
  FastSlamSettings settings;
  MapSmoother smoother(settings);
  Random random(3, 5);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 100; ++i) points.emplace_back(random.uniform(-9, 9), random.uniform(-9, 9), 1);
  Eigen::Isometry3d T_before = Eigen::Isometry3d::Identity();
  for (int i = 0; i < poses; ++i) {
    const double t = step * i;
    const Eigen::Isometry3d T = planar_pose(radius * std::sin(t), radius - radius * std::cos(t), t);
    const Eigen::Isometry3d T_estimated = i == 0 ? T : T * planar_pose(0.01 * random.normal(), 0, 0);
    smoother.add(1'000'000 + i, T_estimated, exact_motion(T_before, T), seen_from(T, 4, points));
    T_before = T;
    if (T_last) *T_last = T;
  }
  return smoother;
}

TEST(MapSmoother, APlaceThatIsVisitedAgainKeepsItsKeyframes) {
  constexpr double step = 0.1;
  constexpr int lap = 63;
  const std::size_t once = lapping(2, step, lap).keyframes();
  const std::size_t twice = lapping(2, step, 2 * lap).keyframes();
  const std::size_t often = lapping(2, step, 10 * lap).keyframes();
  EXPECT_EQ(once, lap);
  EXPECT_GT(2 * twice, 3 * once);  // the second visit closes the loop
  EXPECT_LE(10 * often, 25 * once);
}

TEST(MapSmoother, ALongWayIsThinnedAndItsMotionsHold) {
  constexpr int poses = 700;
  Eigen::Isometry3d T_last;
  const MapSmoother smoother = lapping(8, 0.0085, poses, &T_last);  // no place twice
  EXPECT_LE(smoother.keyframes(), MapSmoother::maximum_keyframes);
  EXPECT_GT(smoother.keyframes(), MapSmoother::maximum_keyframes / 4);
  const auto result = smoother.solve();
  ASSERT_TRUE(result);
  // Motions and observations fit each other, however many poses a motion spans.
  EXPECT_LT(result->cost_after, 1e-2 * result->cost_before);
  for (const SmoothedPose& pose : result->path) {
    const double t = 0.0085 * static_cast<double>(pose.utime - 1'000'000);
    const Eigen::Vector3d truth(8 * std::sin(t), 8 - 8 * std::cos(t), 0);
    EXPECT_LT((pose.T_world_robot.translation() - truth).norm(), 5e-3) << t;
  }
}

// A patrol whose laps close a loop each. (Of 200 the thinning never ended.)
TEST(MapSmoother, LoopsThatAreClosedAgainAndAgainLeaveRoomForTheWay) {
  MapSmoother smoother(FastSlamSettings{});
  Random random(4);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 300; ++i) points.emplace_back(random.uniform(-30, 30), random.uniform(-16, 16), 1);
  constexpr int laps = 190, poses = 180;
  const auto at = [](int i) {
    const double t = 2 * M_PI * i / poses;
    return planar_pose(25 * std::cos(t), 12 * std::sin(t), t);
  };
  Eigen::Isometry3d T_before = Eigen::Isometry3d::Identity();
  for (int i = 0; i < laps * poses; ++i) {
    const Eigen::Isometry3d T = at(i);
    smoother.add(i, T, exact_motion(T_before, T), seen_from(T, 6, points), i > 0 && i % poses == 0);
    T_before = T;
    ASSERT_LE(smoother.keyframes(), MapSmoother::maximum_keyframes);
  }
  const auto smoothed = smoother.solve();
  ASSERT_TRUE(smoothed);
  for (int i = 0; i < poses; ++i) {
    double nearest = 100;  // m
    for (const SmoothedPose& pose : smoothed->path)
      nearest = std::min(nearest, distance_between(pose.T_world_robot, at(i)));
    EXPECT_LT(nearest, 2) << i;
  }
}

// m, median distance of the map's landmarks from the nearest true point.
double map_error(const FastSlam& slam, const synthetic::Drive& drive, const Eigen::Isometry3d& T_start) {
  std::vector<double> errors;
  for (const Landmark& landmark : slam.landmarks()) {
    double nearest = 1;
    for (const auto& point : drive.points)
      nearest = std::min(nearest, (T_start.inverse() * point.position - landmark.mean).norm());
    errors.push_back(nearest);
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<long>(errors.size() / 2), errors.end());
  return errors[errors.size() / 2];
}

TEST(MapSmoother, ADriveIsSmoothedAndTheFilterGoesOn) {
  synthetic::WorldSettings world;
  world.frames = 300;
  double ways[2] = {}, maps[2] = {};  // m, sums over the seeds: online, smoothed
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const auto drive = synthetic::make_drive(world, seed);
    FastSlamSettings settings;
    settings.seed = seed;
    FastSlam slam(settings);
    std::map<Utime, std::pair<Eigen::Vector3d, Eigen::Vector3d>> paths;  // truth, online
    for (std::size_t i = 0; i < 250; ++i) {
      const auto& step = drive.steps[i];
      const StepResult r = slam.step(step.motion, step.frame);
      paths[step.frame.utime] = {step.T_start_robot.translation(), r.T_world_robot.translation()};
    }
    const Eigen::Isometry3d T_start = synthetic::true_pose(world, 0);
    const double map_before = map_error(slam, drive, T_start);
    const auto path = slam.smooth();
    ASSERT_GT(path.size(), 50U);
    const double map_after = map_error(slam, drive, T_start);
    double online = 0, smoothed = 0;
    for (const SmoothedPose& pose : path) {
      const auto& [truth, said] = paths.at(pose.utime);
      online += (said - truth).squaredNorm();
      smoothed += (pose.T_world_robot.translation() - truth).squaredNorm();
    }
    online = std::sqrt(online / static_cast<double>(path.size()));
    smoothed = std::sqrt(smoothed / static_cast<double>(path.size()));
    RecordProperty("seed_" + std::to_string(seed),
                   "path " + std::to_string(online) + " smoothed " + std::to_string(smoothed) + ", map " +
                       std::to_string(map_before) + " smoothed " + std::to_string(map_after));
    ways[0] += online, ways[1] += smoothed;
    maps[0] += map_before, maps[1] += map_after;
    for (std::size_t i = 250; i < drive.steps.size(); ++i) {
      const StepResult r = slam.step(drive.steps[i].motion, drive.steps[i].frame);
      EXPECT_EQ(r.status, TrackStatus::tracking) << "frame " << i;
      EXPECT_LT((r.T_world_robot.translation() - drive.steps[i].T_start_robot.translation()).norm(), 0.06);
    }
  }
  // One drive's smoothed map may be worse than the filter's, by what the camera errs in all its images.
  EXPECT_LT(ways[1], 0.9 * ways[0]);
  EXPECT_LT(maps[1], 0.95 * maps[0]);
}

// Where the robot stands still nothing is new: it is corrected once, however often somebody asks.
TEST(MapSmoother, ARobotThatStandsIsCorrectedOnce) {
  synthetic::WorldSettings world;
  world.frames = 250;
  double first = 0, again = 0;  // m, sums over the seeds
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto drive = synthetic::make_drive(world, seed);
    FastSlamSettings settings;
    settings.seed = seed;
    FastSlam slam(settings);
    for (const auto& step : drive.steps) slam.step(step.motion, step.frame);
    const auto where = [&](const FastSlam& s) {
      const auto& weights = s.weights();
      const auto best = std::max_element(weights.begin(), weights.end()) - weights.begin();
      return Eigen::Vector3d(s.particles()[static_cast<std::size_t>(best)].T_world_robot.translation());
    };
    const Eigen::Vector3d before = where(slam);
    slam.smooth();
    const Eigen::Vector3d once = where(slam);
    for (int i = 0; i < 5; ++i) slam.smooth();
    first += (once - before).norm();
    again += (where(slam) - once).norm();
  }
  std::cout << "moved " << first << " m, then " << again << " m\n";
  EXPECT_GT(first, 0.01);
  EXPECT_LT(again, 0.1 * first);
}

// Smoothing beside the filter is taken over at a message time, however long it computes.
TEST(MapSmoother, BesideTheFilterItIsDeterministic) {
  synthetic::WorldSettings world;
  world.frames = 120;
  const auto drive = synthetic::make_drive(world, 3);
  std::vector<std::vector<Eigen::Isometry3d>> paths;
  for (const int repeat : {0, 1}) {
    FastSlam slam(FastSlamSettings{});
    EXPECT_FALSE(slam.begin_smoothing());
    paths.emplace_back();
    std::size_t taken_at = 0;
    for (std::size_t i = 0; i < drive.steps.size(); ++i) {
      paths.back().push_back(slam.step(drive.steps[i].motion, drive.steps[i].frame).T_world_robot);
      if (i == 60) {
        EXPECT_TRUE(slam.begin_smoothing());
        EXPECT_FALSE(slam.begin_smoothing());  // one at a time
      }
      if (!slam.take_smoothed().empty()) taken_at = i;
    }
    EXPECT_EQ(taken_at, 80U) << repeat;  // 2 s later, frames 0.1 s apart
  }
  for (std::size_t i = 0; i < paths[0].size(); ++i)
    EXPECT_EQ(paths[0][i].matrix(), paths[1][i].matrix()) << "frame " << i;
}

}  // namespace
}  // namespace lcmslam
