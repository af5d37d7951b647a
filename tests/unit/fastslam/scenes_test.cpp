// Hard moments: lost, blind, round a loop, in a changed room.

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>

#include <lcmslam/fastslam/fastslam.hpp>
#include "tests/unit/fastslam/synthetic_world.hpp"

namespace lcmslam {
namespace {

using synthetic::Drive;
using synthetic::make_drive;
using synthetic::short_world;
using synthetic::WorldSettings;

TEST(FastSlam, LostRobotIsFoundBack) {
  const Drive drive = make_drive(short_world(260), 8);
  FastSlam slam((FastSlamSettings()));
  for (int i = 0; i < 230; ++i) {  // more than one lap
    const auto& step = drive.steps[static_cast<std::size_t>(i)];
    slam.step(step.motion, step.frame);
  }
  // Carried away unseen to a pose of the first lap.
  bool relocalised = false;
  double error = 1e9;
  for (int i = 60; i < 80; ++i) {
    const auto& step = drive.steps[static_cast<std::size_t>(i)];
    const StepResult r = slam.step(step.motion, step.frame);
    relocalised |= r.status == TrackStatus::relocalised;
    error = (r.T_world_robot.translation() - step.T_start_robot.translation()).norm();
  }
  EXPECT_TRUE(relocalised);
  EXPECT_LT(error, 0.06);
}

// The depth camera goes blind; pixels of mapped landmarks keep the pose.
TEST(FastSlam, BearingsCarryThroughBlindDepth) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    WorldSettings world = short_world(330);  // a lap and a half
    world.slips = false;
    Drive drive = make_drive(world, seed);
    double error[2] = {0, 0};
    for (const bool bearings : {false, true}) {
      FastSlamSettings settings;
      settings.use_bearings = bearings;
      FastSlam slam(settings);
      const std::size_t blind = 260;
      int created = 0;
      for (std::size_t i = 0; i < drive.steps.size(); ++i) {
        FeatureFrame frame = drive.steps[i].frame;
        if (i >= blind)
          for (Feature& f : frame.features) {
            f.kind = MeasurementKind::bearing;
            f.point.setConstant(std::numeric_limits<float>::quiet_NaN());
            f.depth_sigma = std::numeric_limits<float>::quiet_NaN();
          }
        Motion motion = drive.steps[i].motion;
        if (i >= blind) {  // wheels that drift, and say so
          motion.T_from_to = motion.T_from_to * planar_pose(0.002, 0.001, 0.003);
          motion.covariance = 1e-5 * Matrix6d::Identity();
        }
        const StepResult r = slam.step(motion, frame);
        if (i < blind) continue;
        created += r.created;
        EXPECT_EQ(r.offered, 0);
        if (bearings) {
          EXPECT_GT(r.used, 5) << i;
        }
        error[bearings] =
            std::max(error[bearings],
                     (r.T_world_robot.translation() - drive.steps[i].T_start_robot.translation()).norm());
      }
      EXPECT_EQ(created, 0);
    }
    EXPECT_LT(error[1], 0.5 * error[0]);
    EXPECT_LT(error[1], 0.06);
  }
}

// One side of the room, then, after a blind turn that the odometry tells wrongly by half a metre and 17
// degrees, the other side, which is mapped at a wrong place; then back over what lies between.
TEST(FastSlam, PlaceRecognitionClosesALoop) {
  WorldSettings world;
  world.landmarks = 2500;
  int closed = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    for (const bool close_loops : {true, false}) {
      SCOPED_TRACE("seed " + std::to_string(seed) + (close_loops ? "" : " without"));
      Random random(seed);
      const auto points = synthetic::make_points(world, random);
      FastSlamSettings settings;
      settings.close_loops = close_loops;
      FastSlam slam(settings);
      std::vector<int> truth;
      Eigen::Isometry3d T_before = planar_pose(0, 0, 0);
      const Eigen::Isometry3d T_start = T_before;
      StepResult r;
      int jumps = 0;
      const auto go = [&](double heading, const Eigen::Isometry3d& error, bool blind) {
        const Eigen::Isometry3d T = planar_pose(0, 0, heading);
        Motion motion;
        motion.T_from_to = T_before.inverse() * T * error;
        motion.covariance = 1e-6 * Matrix6d::Identity();
        FeatureFrame frame = synthetic::see(world, points, T, random, truth);
        if (blind) frame.features.clear();
        r = slam.step(motion, frame);
        jumps += r.status == TrackStatus::relocalised;
        T_before = T;
        return ((T_start.inverse() * T).inverse() * r.T_world_robot).translation().norm();
      };
      const Eigen::Isometry3d honest = Eigen::Isometry3d::Identity();
      double heading = 0;
      for (; heading < 0.5; heading += 0.03) EXPECT_LT(go(heading, honest, false), 0.05);
      for (heading = 3; heading < 3.3; heading += 0.03)
        go(heading, heading == 3 ? planar_pose(0.4, 0.3, 0.3) : honest, heading == 3);
      double error = 0;
      for (; heading < 2 * M_PI + 0.4; heading += 0.03) error = go(heading, honest, false);
      if (close_loops) {
        EXPECT_LT(error, 0.05);
        EXPECT_GE(jumps, 1);
        closed += jumps;
      } else {
        EXPECT_GT(error, 0.2) << "nothing to close";
      }
    }
  EXPECT_LE(closed, 6) << "a loop is closed once";
}

// The same world: what was mapped astray before the loop closed comes to where it is, without being asked.
// Particles may scatter past the one view that closes it: of all worlds and draws two thirds must.
TEST(FastSlam, AClosedLoopBendsTheMap) {
  WorldSettings world;
  world.landmarks = 2500;
  int mended = 0;
  for (std::uint64_t run = 0; run < 15; ++run) {
    const std::uint64_t seed = 1 + run % 5;
    Random random(seed);
    const auto points = synthetic::make_points(world, random);
    FastSlamSettings settings;
    settings.bend_closed_loops = true;
    settings.timing_sigma = 0;          // this world's images have exact moments
    settings.remove_landmarks = false;  // astray, they would die in the end
    settings.seed = 1 + run / 5;
    FastSlam slam(settings);
    std::vector<int> truth;
    const Eigen::Isometry3d T_start = planar_pose(0, 0, 0);
    Eigen::Isometry3d T_before = T_start;
    const auto off_surface = [&](const std::set<std::int64_t>& which) {  // m, mean to the nearest true point
      double sum = 0;
      int count = 0;
      for (const Landmark& landmark : slam.landmarks()) {
        if (which.count(landmark.id) == 0) continue;
        double nearest = 1;
        for (const auto& point : points)
          nearest = std::min(nearest, (T_start.inverse() * point.position - landmark.mean).norm());
        sum += nearest;
        ++count;
      }
      EXPECT_GT(count, 20);
      return sum / std::max(1, count);
    };
    std::set<std::int64_t> astray;
    double before = 0, heading = 0;
    int closed = -1, step = 0;
    const auto go = [&](const Eigen::Isometry3d& error, bool blind) {
      const Eigen::Isometry3d T = planar_pose(0, 0, heading);
      Motion motion;
      motion.T_from_to = T_before.inverse() * T * error;
      motion.covariance = (blind ? 0.1 : 1e-4) * Matrix6d::Identity();  // it knows that it does not know
      FeatureFrame frame = synthetic::see(world, points, T, random, truth);
      frame.utime = 1'000'000 + 100'000 * ++step;
      if (blind) frame.features.clear();
      const StepResult r = slam.step(motion, frame);
      if (r.loop_closed && closed < 0) {
        closed = step;
        before = off_surface(astray);
      }
      T_before = T;
      return ((T_start.inverse() * T).inverse() * r.T_world_robot).translation().norm();
    };
    const Eigen::Isometry3d honest = Eigen::Isometry3d::Identity();
    for (; heading < 0.5; heading += 0.03) go(honest, false);
    std::set<std::int64_t> first;
    for (const Landmark& landmark : slam.landmarks()) first.insert(landmark.id);
    for (heading = 3; heading < 3.3; heading += 0.03)
      go(heading == 3 ? planar_pose(0.4, 0.3, 0.3) : honest, heading == 3);
    for (const Landmark& landmark : slam.landmarks())
      if (first.count(landmark.id) == 0) astray.insert(landmark.id);
    double error = 1;
    for (; heading < 2 * M_PI + 0.4; heading += 0.03) error = go(honest, false);
    for (int i = 0; i < 25; ++i) error = go(honest, false);  // the solver has 2 s
    const double after = closed > 0 ? off_surface(astray) : before;
    std::cout << "world " << seed << ", draws " << settings.seed << ": landmarks astray " << before
              << " m, bent " << after << " m, robot " << error << " m\n";
    if (closed > 0 && before > 0.03 && after < 0.5 * before && error < 0.05) ++mended;
  }
  EXPECT_GE(mended, 10);
}

TEST(FastSlam, LandmarksOfARemovedObjectDie) {
  Drive drive = make_drive(short_world(1), 9);
  WorldSettings world;
  FastSlam slam((FastSlamSettings()));
  Random random(1);
  std::vector<int> truth;
  std::set<std::int64_t> gone;  // landmarks in the image's middle
  const Eigen::Isometry3d T = synthetic::true_pose(world, 0);
  const auto in_the_middle = [](const Feature& f) {
    return f.x > 200 && f.x < 440 && f.y > 150 && f.y < 330;
  };
  const auto mistaken = [&](std::size_t i) { return truth[i] < 0; };
  for (int i = 0; i < 60; ++i) {
    FeatureFrame frame = synthetic::see(world, drive.points, T, random, truth);
    if (i >= 10) {  // other things stand there now, at the same depth
      for (std::size_t k = 0; k < frame.features.size(); ++k)
        if (in_the_middle(frame.features[k]) && !mistaken(k))
          frame.features[k].descriptor =
              synthetic::noisy_bytes(synthetic::random_descriptor(random), 0, random);
    }
    const StepResult r = slam.step(Motion(), frame);
    if (i == 9)
      for (const auto& o : r.observations)
        if (in_the_middle(frame.features[static_cast<std::size_t>(o.feature)])) gone.insert(o.landmark);
  }
  ASSERT_GT(gone.size(), 5u);
  std::size_t left = 0, others = 0;
  for (const auto& landmark : slam.landmarks()) (gone.count(landmark.id) ? left : others) += 1;
  EXPECT_LE(left, gone.size() / 5);
  EXPECT_GT(others, 15u);
}

}  // namespace
}  // namespace lcmslam
