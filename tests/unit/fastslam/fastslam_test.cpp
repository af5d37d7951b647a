#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include <lcmslam/fastslam/fastslam.hpp>
#include "tests/unit/fastslam/synthetic_world.hpp"

namespace lcmslam {
namespace {

using synthetic::Drive;
using synthetic::make_drive;
using synthetic::short_world;
using synthetic::WorldSettings;

TEST(FastSlam, FirstStepIsTheOriginAndMakesLandmarks) {
  const Drive drive = make_drive(short_world(1), 1);
  FastSlam slam(thesis_preset());
  Motion nonsense;
  nonsense.T_from_to = planar_pose(5, 5, 1);
  const StepResult r = slam.step(nonsense, drive.steps[0].frame);
  EXPECT_TRUE(r.T_world_robot.isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_EQ(r.status, TrackStatus::initialising);
  EXPECT_EQ(r.created, r.offered);
  const auto landmarks = slam.landmarks();
  ASSERT_EQ(static_cast<int>(landmarks.size()), r.offered);
  for (const auto& landmark : landmarks) {  // each is a feature's point, carried to the robot frame
    double nearest = 1e9;
    for (const Feature& f : drive.steps[0].frame.features)
      nearest = std::min(
          nearest, (drive.steps[0].frame.T_robot_camera * f.point.cast<double>() - landmark.mean).norm());
    EXPECT_LT(nearest, 1e-9);
  }
}

// Exact measurements, exact odometry: the answer is known.
TEST(FastSlam, ExactInputsGiveTheExactPose) {
  WorldSettings world = short_world(60);
  world.pixel_sigma = 1e-3;
  world.wiggle = 0;
  world.wrong_match = world.clutter = world.scale_error = world.rotation_error = 0;
  world.slips = false;
  Drive drive = make_drive(world, 2);
  for (auto& step : drive.steps) {
    step.frame.pixel_sigma = 1;  // stated; the points themselves are put exactly on the truth
    for (Feature& f : step.frame.features) {
      const auto& point = drive.points[static_cast<std::size_t>(
          step.truth[static_cast<std::size_t>(&f - step.frame.features.data())])];
      const Eigen::Isometry3d T_world_camera =
          synthetic::true_pose(world, 0) * step.T_start_robot * step.frame.T_robot_camera;
      f.point = (T_world_camera.inverse() * point.position).cast<float>();
    }
  }
  FastSlamSettings settings;
  FastSlam slam(settings);
  StepResult last;
  for (const auto& step : drive.steps) last = slam.step(step.motion, step.frame);
  EXPECT_LT((last.T_world_robot.translation() - drive.steps.back().T_start_robot.translation()).norm(), 0.01);
  std::size_t close = 0;
  for (const auto& landmark : slam.landmarks()) {
    double nearest = 1e9;
    for (const auto& p : drive.points)
      nearest =
          std::min(nearest, (synthetic::true_pose(world, 0).inverse() * p.position - landmark.mean).norm());
    close += nearest < 0.02;
  }
  EXPECT_GE(close, slam.landmarks().size() * 95 / 100);
}

TEST(FastSlam, BadInputNeverBreaksIt) {
  const Drive drive = make_drive(short_world(60), 7);
  FastSlam slam((FastSlamSettings()));
  Random random(1);
  for (const auto& step : drive.steps) {
    Motion motion = step.motion;
    FeatureFrame frame = step.frame;
    if (frame.seq % 10 == 3) frame.features.clear();
    if (frame.seq % 10 == 5) motion.T_from_to.translation().setConstant(std::nan(""));
    if (frame.seq % 10 == 7) motion.covariance.setConstant(std::nan(""));
    if (frame.seq % 10 == 9)
      for (Feature& f : frame.features) {
        if (random.below(3) == 0) f.point.setConstant(std::numeric_limits<float>::quiet_NaN());
        if (random.below(9) == 0) f.depth_sigma = 0;
      }
    const StepResult r = slam.step(motion, frame);
    ASSERT_TRUE(r.T_world_robot.matrix().allFinite());
    ASSERT_TRUE(r.covariance.allFinite());
    EXPECT_EQ(r.covariance, r.covariance.transpose().eval());
    EXPECT_GT(r.covariance.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0);
    if (frame.seq > 0) {
      EXPECT_EQ(r.motion_usable, frame.seq % 10 != 5 && frame.seq % 10 != 7);
    }
    if (frame.seq % 10 == 3) {
      EXPECT_EQ(r.status, TrackStatus::predicting);
    }
    EXPECT_LT((r.T_world_robot.translation() - step.T_start_robot.translation()).norm(), 0.1) << frame.seq;
  }
}

// For display: every feature that was matched or made a landmark, with what became of it.
TEST(FastSlam, AssociationsAddUpToTheCounts) {
  const Drive drive = make_drive(short_world(40), 13);
  FastSlamSettings settings;
  settings.maximum_observations = 20;
  FastSlam slam(settings);
  std::map<AssociationOutcome, int> all;
  for (const auto& step : drive.steps) {
    const StepResult r = slam.step(step.motion, step.frame);
    std::map<AssociationOutcome, int> count;
    std::map<std::pair<int, AssociationOutcome>, std::int64_t> landmark;
    for (const auto& a : r.associations) {
      ++count[a.outcome];
      ++all[a.outcome];
      EXPECT_TRUE(landmark.emplace(std::pair(a.feature, a.outcome), a.landmark).second);
    }
    EXPECT_EQ(count[AssociationOutcome::accepted], r.used);
    EXPECT_EQ(count[AssociationOutcome::accepted] + count[AssociationOutcome::unused], r.matched);
    EXPECT_EQ(count[AssociationOutcome::rejected], r.rejected);
    EXPECT_EQ(count[AssociationOutcome::created], r.created);
    for (const auto& o : r.observations) {
      const auto outcome = o.accepted ? AssociationOutcome::accepted : AssociationOutcome::rejected;
      EXPECT_EQ(landmark.at({o.feature, outcome}), o.landmark);
    }
  }
  EXPECT_EQ(all.size(), 4u) << "each outcome happened";
}

// Particles share what they inherited: landmarks that were not seen for a while are the same memory in most.
// How many lineages live on after a while is chance, so several drives count together.
TEST(FastSlam, ParticlesShareTheirMaps) {
  FastSlamSettings settings;
  settings.resample_fraction = 1;
  int old = 0, copies = 0;
  for (const int seed : {12, 13, 14, 15}) {
    FastSlam slam(settings);
    for (const auto& step : make_drive(short_world(200), seed).steps) slam.step(step.motion, step.frame);
    std::set<const void*> nodes;
    std::size_t shared = 0, one = 0;
    for (const Particle& particle : slam.particles())
      particle.map.for_each_node([&](const void* node, std::size_t bytes) {
        if (nodes.insert(node).second) shared += bytes;
      });
    slam.particles()[0].map.for_each_node([&](const void*, std::size_t bytes) { one += bytes; });
    EXPECT_LT(shared, 60 * one) << "of 100 maps of " << one << " bytes, seed " << seed;
    const int old_before = old, before = copies;
    for (int slot = 0; slot < slam.index().slots(); ++slot) {
      if (!slam.index().alive(slot) || slam.index().unseen_steps(slot) < 100) continue;
      std::set<const void*> places;
      for (const Particle& particle : slam.particles())
        places.insert(particle.map.find(static_cast<std::size_t>(slot)));
      copies += static_cast<int>(places.size());
      ++old;
    }
    std::cout << "seed " << seed << ": " << copies - before << " copies of " << old - old_before
              << " old landmarks\n";
  }
  ASSERT_GT(old, 200);
  EXPECT_LT(copies, 40 * old) << "of 100";
}

TEST(Publication, ChangesAddUpToTheMap) {
  const Drive drive = make_drive(short_world(80), 11);
  FastSlam slam((FastSlamSettings()));
  std::map<std::int64_t, Eigen::Vector3d> received;
  std::int64_t revision = 0;
  std::size_t sent = 0, whole = 0;
  for (const auto& step : drive.steps) {
    slam.step(step.motion, step.frame);
    const MapChanges changes = slam.take_changes();
    EXPECT_GE(changes.revision, revision);
    revision = changes.revision;
    for (const std::int64_t id : changes.removed) EXPECT_EQ(received.erase(id), 1u);
    for (const auto& landmark : changes.changed) received[landmark.id] = landmark.mean;
    sent += changes.changed.size();
    const auto landmarks = slam.landmarks();
    whole += landmarks.size();
    ASSERT_EQ(received.size(), landmarks.size());
    for (const auto& landmark : landmarks) {
      ASSERT_EQ(received.count(landmark.id), 1u);
      EXPECT_LE((received[landmark.id] - landmark.mean).norm(), 0.005 + 1e-12);
    }
  }
  EXPECT_LT(sent, whole / 2) << "only what changed goes out";
  EXPECT_TRUE(slam.take_changes().changed.empty());
}

}  // namespace
}  // namespace lcmslam
