// Both trackers alone: how a frame is placed in a map that is there.

#include <lcmslam/dense_mapper/tracker.hpp>

#include <gtest/gtest.h>

#include <lcmslam/dense_mapper/contradiction.hpp>
#include <lcmslam/dense_mapper/modern_tracker.hpp>
#include <lcmslam/dense_mapper/thesis/thesis_tracker.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

/// The room, seen by a robot whose camera is its origin.
Cloud seen_from(const Eigen::Isometry3d& T_world_robot) {
  Cloud cloud = transformed(room(0.03), T_world_robot.inverse());
  cloud.sigmas.assign(cloud.size(), 0.003f);
  return cloud;
}

Expectation expectation(const Eigen::Isometry3d& T_world_robot, double sigma = 0.1) {
  Expectation expected;
  expected.prior.T_target_source = T_world_robot;
  expected.prior.information = Matrix6d::Identity() / (sigma * sigma);
  expected.T_world_last = T_world_robot;
  return expected;
}

double error(const Eigen::Isometry3d& found, const Eigen::Isometry3d& truth) {
  return distance_between(found, truth) + angle_between(found, truth);
}

const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
const Eigen::Isometry3d nearby = se3_exp(twist(0.04, -0.03, 0.01, 0.01, 0, 0.03));

class ModernTracking : public testing::Test {
 protected:
  ModernTracking() : map_(settings_), keyframes_(settings_), tracker_(settings_, map_, keyframes_) {
    map_.insert(seen_from(here), Eigen::Isometry3d::Identity(), 0);
  }

  Tracked track(const Cloud& cloud, const Expectation& expected,
                std::optional<Motion> motion = std::nullopt) {
    DenseFrame frame;
    frame.cloud = cloud;
    frame.motion = std::move(motion);
    return tracker_.track({frame, cloud}, expected);
  }

  DenseMapperSettings settings_;
  DeformableMap map_;
  KeyframeStore keyframes_;
  ModernTracker tracker_;
};

TEST(MakeTracker, TheVariantNamesIt) {
  DenseMapperSettings settings;
  DeformableMap map(settings);
  const KeyframeStore keyframes(settings);
  EXPECT_NE(dynamic_cast<ModernTracker*>(make_tracker(settings, map, keyframes).get()), nullptr);
  for (const auto variant : {VariantKind::plain, VariantKind::alternating, VariantKind::frustum}) {
    settings.variant = variant;
    EXPECT_NE(dynamic_cast<ThesisTracker*>(make_tracker(settings, map, keyframes).get()), nullptr);
  }
  EXPECT_THROW(ThesisTracker(VariantKind::modern, {}), std::invalid_argument);
}

TEST_F(ModernTracking, CorrectsAPredictionThatErrs) {
  const Tracked tracked = track(seen_from(nearby), expectation(here));
  EXPECT_EQ(to_string(tracked.status), "tracking");
  EXPECT_LT(error(tracked.registration.T_target_source, nearby), 0.1 * error(here, nearby));
  EXPECT_GT(tracked.quality, 0.8);
  EXPECT_FALSE(tracked.anchored);
  EXPECT_TRUE(tracked.prior.T_target_source.isApprox(here));
}

TEST_F(ModernTracking, TooFewPointsAreLostAtThePrediction) {
  Cloud few = seen_from(here);
  few = kept_points(few, [](std::size_t i) { return i < 199; });
  const Tracked tracked = track(few, expectation(nearby));
  EXPECT_EQ(to_string(tracked.status), "lost");
  EXPECT_TRUE(tracked.registration.T_target_source.isApprox(nearby));
}

// A robot that was carried away: keyframes are starts, unless wheels say that it cannot be there.
TEST_F(ModernTracking, KeyframesAreStartsWhenTheRobotMayBeAnywhere) {
  keyframes_.add(0, 0, here, {});
  Expectation far = expectation(planar_pose(-2, 1.5, 1.2));
  EXPECT_EQ(to_string(track(seen_from(nearby), far).status), "lost");
  far.bad_steps = 1;
  Motion motion;
  EXPECT_EQ(to_string(track(seen_from(nearby), far, motion).status), "lost");
  motion.visual = true;
  far.adrift = true;
  const Tracked tracked = track(seen_from(nearby), far, motion);
  EXPECT_EQ(to_string(tracked.status), "tracking");
  EXPECT_LT(error(tracked.registration.T_target_source, nearby), 0.01);
}

// One bad frame, and a keyframe where all looks alike: without wheels, too, it stands where it can have come
// to.
TEST_F(ModernTracking, NobodyLeapsToAKeyframeFartherThanHeCanHaveCome) {
  keyframes_.add(0, 0, here, {});
  for (const double sigma : {0.05, 1.0}) {
    Expectation far = expectation(planar_pose(-0.6, 0.3, 0.1), sigma);
    far.T_world_last = far.prior.T_target_source;
    far.bad_steps = 1;
    const Tracked tracked = track(seen_from(nearby), far);
    EXPECT_EQ(to_string(tracked.status), sigma < 0.1 ? "lost" : "tracking");
    EXPECT_LT(error(tracked.registration.T_target_source, nearby), 0.01) << "that it fits is no question";
  }
}

// A floor fits everywhere: whoever may be anywhere is not there because he sees one.
TEST_F(ModernTracking, AFloorIsNoPlaceToBeFoundAt) {
  Cloud floor;
  add_rectangle(floor, {1, -1.5, -1}, {2, 0, 0}, {0, 3, 0}, 0.03);
  floor.sigmas.assign(floor.size(), 0.003f);
  Expectation expected = expectation(here);
  EXPECT_EQ(to_string(track(floor, expected).status), "tracking");
  expected.adrift = true;
  EXPECT_EQ(to_string(track(floor, expected).status), "lost");
  EXPECT_EQ(to_string(track(seen_from(here), expected).status), "tracking");
}

// It fits, but things of the map stand in between.
TEST_F(ModernTracking, WhereTheMapIsLookedThroughIsNoPlaceToBeFoundAt) {
  Cloud between;
  for (const double x : {1.2, 1.5, 1.8, 2.1, 2.4})
    add_rectangle(between, {x, -0.45 * x, -0.3 * x}, {0, 0, 0.6 * x}, {0, 0.9 * x, 0}, 0.03);
  between.sigmas.assign(between.size(), 0.003f);
  const Cloud seen = seen_from(here);
  DenseFrame frame;
  frame.T_robot_camera = optical_axes();
  frame.cloud = transformed(seen, optical_axes().inverse());
  Expectation expected = expectation(here);
  for (const bool adrift : {true, false}) {
    expected.adrift = adrift;
    EXPECT_EQ(to_string(tracker_.track({frame, seen}, expected).status), "tracking");
  }
  map_.insert(between, Eigen::Isometry3d::Identity(), 0);
  for (const bool adrift : {true, false}) {
    expected.adrift = adrift;
    EXPECT_EQ(to_string(tracker_.track({frame, seen}, expected).status), adrift ? "lost" : "tracking");
  }
}

// A frame that fits where the wheels cannot have led in one step shows another place, unless nobody knows how
// the robot moved.
TEST_F(ModernTracking, WhatFitsFarBesideTheWheelsWayIsLost) {
  const Eigen::Isometry3d aside = se3_exp(twist(0.16, 0.1, 0, 0, 0, 0.02));
  Motion motion;
  EXPECT_EQ(to_string(track(seen_from(aside), expectation(here, 0.05), motion).status), "tracking");
  const Expectation surer = expectation(here, 0.02);
  EXPECT_EQ(to_string(track(seen_from(aside), surer, motion).status), "lost");
  EXPECT_EQ(to_string(track(seen_from(aside), surer).status), "tracking");
  motion.visual = true;
  EXPECT_EQ(to_string(track(seen_from(aside), surer, motion).status), "tracking");
}

/// Who fills the view of a robot at its origin.
Cloud somebody_at(double x) {
  Cloud close;
  add_rectangle(close, {x, -1.2, -1.2}, {0, 0, 2.4}, {0, 2.4, 0}, 0.015);
  close.sigmas.assign(close.size(), 0.003f);
  return close;
}

/// What a robot whose wheels stand sees.
Tracked look_standing(ModernTracker& tracker, const Cloud& seen) {
  Expectation expected = expectation(here, 0.003);
  expected.pushed = std::make_shared<const Expectation>(expectation(here, 0.03));
  DenseFrame frame;
  frame.T_robot_camera = optical_axes();
  frame.cloud = transformed(seen, optical_axes().inverse());
  frame.motion = Motion();
  return tracker.track({frame, seen}, expected);
}

// Wheels that stand say nothing of a push: all of the map that is in sight has moved then. Where one thing of
// it has, and hides the rest, it is that which was pushed.
TEST_F(ModernTracking, ARobotThatStandsIsPushedOnlyWhereMostOfTheMapMoves) {
  const Eigen::Isometry3d there = planar_pose(0.05, -0.04, 0.05);
  const Tracked pushed = look_standing(tracker_, seen_from(there));
  EXPECT_EQ(to_string(pushed.status), "tracking");
  EXPECT_TRUE(pushed.pushed);
  EXPECT_LT(error(pushed.registration.T_target_source, there), 0.03);
  EXPECT_FALSE(look_standing(tracker_, seen_from(here)).pushed);

  map_.insert(somebody_at(1.5), Eigen::Isometry3d::Identity(), 0);
  EXPECT_EQ(to_string(look_standing(tracker_, somebody_at(1.5)).status), "tracking");
  EXPECT_EQ(to_string(look_standing(tracker_, somebody_at(1.58)).status), "lost");
}

// Nor where nothing else that is near is mapped: who steps back takes no robot along.
TEST_F(ModernTracking, WhatIsCloseAndGoesPushesNobody) {
  DeformableMap map(settings_);
  ModernTracker tracker(settings_, map, keyframes_);
  map.insert(somebody_at(0.8), Eigen::Isometry3d::Identity(), 0);
  EXPECT_EQ(to_string(look_standing(tracker, somebody_at(0.8)).status), "tracking");
  EXPECT_EQ(to_string(look_standing(tracker, somebody_at(0.88)).status), "lost");
}

/// A corridor that a robot at its origin looks along: nothing of it tells how far, but what stands ahead.
Cloud corridor_with(double x, double half_width) {
  Cloud cloud;
  for (const double y : {-1.2, 1.2}) add_rectangle(cloud, {0.5, y, -1}, {4, 0, 0}, {0, 0, 2}, 0.08);
  add_rectangle(cloud, {0.5, -1.2, -1}, {4, 0, 0}, {0, 2.4, 0}, 0.08);
  add_rectangle(cloud, {x, -half_width, -1}, {0, 0, 1.8}, {0, 2 * half_width, 0}, 0.015);
  cloud.sigmas.assign(cloud.size(), 0.003f);
  return cloud;
}

// Wheels that stand are believed where one thing alone says that they rolled: somebody has walked off. A wall
// does not.
TEST_F(ModernTracking, OneThingThatGoesTakesNoRobotAlongThatStands) {
  const auto look_at = [&](double half_width, bool stands) {
    DeformableMap map(settings_);
    ModernTracker tracker(settings_, map, keyframes_);
    map.insert(corridor_with(1.8, half_width), Eigen::Isometry3d::Identity(), 0);
    Expectation expected = expectation(here, 0.03);
    if (stands) expected.T_world_stood = here;
    DenseFrame frame;
    frame.cloud = corridor_with(1.82, half_width);
    frame.motion = Motion();
    return tracker.track({frame, frame.cloud}, expected);
  };
  const Tracked thing = look_at(0.25, true), wall = look_at(1.2, true);
  EXPECT_EQ(to_string(thing.status), "tracking");
  EXPECT_FALSE(thing.pushed);
  EXPECT_GT(error(look_at(0.25, false).registration.T_target_source, here), 0.015) << "as it leads";
  EXPECT_LT(error(thing.registration.T_target_source, here), 0.005);
  EXPECT_EQ(to_string(wall.status), "tracking");
  EXPECT_TRUE(wall.pushed);
  EXPECT_LT(error(wall.registration.T_target_source, planar_pose(-0.02, 0, 0)), 0.005);
}

// Nor where enough else stands: what moves is much of the view, and no wall.
TEST_F(ModernTracking, WhatMovesAmidAllThatStandsTakesNoRobotAlong) {
  Cloud walls = seen_from(here);
  const auto with_board = [&](double x) {
    Cloud seen = walls;
    for (const double y : {-1.6, 1.0}) {
      Cloud board;
      add_rectangle(board, {x, y, -1}, {0, 0, 1.8}, {0, 0.6, 0}, 0.02);
      board.sigmas.assign(board.size(), 0.003f);
      seen.points.insert(seen.points.end(), board.points.begin(), board.points.end());
      seen.normals.insert(seen.normals.end(), board.normals.begin(), board.normals.end());
      seen.sigmas.insert(seen.sigmas.end(), board.sigmas.begin(), board.sigmas.end());
    }
    return seen;
  };
  map_.insert(with_board(1), Eigen::Isometry3d::Identity(), 0);
  const auto standing = what_stands(with_board(1.04), here, planar_pose(-0.04, 0, 0), map_.voxels());
  ASSERT_TRUE(standing);
  const Tracked tracked = track(*standing, expectation(here, 0.003));
  EXPECT_LT(error(tracked.registration.T_target_source, here), 0.005);
  EXPECT_LT(standing->size(), with_board(1).size() - 1000);
  // All of it, where the robot was pushed.
  EXPECT_FALSE(what_stands(transformed(with_board(1), planar_pose(0.04, 0, 0)), here,
                           planar_pose(-0.04, 0, 0), map_.voxels()));
}

// The place before, and no keyframe, is another start.
TEST_F(ModernTracking, WhereItWasLastIsAStart) {
  Expectation far = expectation(planar_pose(-2, 1.5, 1.2));
  far.T_world_last = here;
  far.bad_steps = 1;
  EXPECT_EQ(to_string(track(seen_from(nearby), far, Motion()).status), "tracking");
}

TEST_F(ModernTracking, FollowsTheMapWhenItIsDeformed) {
  const Eigen::Isometry3d aside = planar_pose(0.5, 2, 0.4);
  tracker_.deform(map_.deform({aside}));
  const Tracked tracked = track(seen_from(nearby), expectation(aside * here));
  EXPECT_EQ(to_string(tracked.status), "tracking");
  EXPECT_LT(error(tracked.registration.T_target_source, aside * nearby), 0.01);
}

TEST(ThesisTracking, BelievesWhatConvergesAndGrowsByWhatIsAccepted) {
  ThesisSettings settings;
  settings.icp.registration.max_distance = 0.3;
  ThesisTracker tracker(VariantKind::plain, settings);
  DenseFrame frame;
  tracker.accept({frame, seen_from(here)}, here, true);
  const std::size_t size = tracker.target().size();
  const Tracked tracked = tracker.track({frame, seen_from(nearby)}, expectation(here));
  EXPECT_EQ(to_string(tracked.status), "tracking");
  // Point to point slides slowly along surfaces: it stops on its way.
  EXPECT_LT(error(tracked.registration.T_target_source, nearby), 0.8 * error(here, nearby));
  EXPECT_EQ(tracker.target().size(), size);
  // No point has a partner: nothing converges.
  const Tracked lost = tracker.track({frame, seen_from(planar_pose(50, 0, 0))}, expectation(here));
  EXPECT_EQ(to_string(lost.status), "lost");
  // Whoever placed it.
  tracker.accept({frame, seen_from(here)}, planar_pose(0, 9, 0), false);
  EXPECT_EQ(tracker.target().size(), 2 * size);
}

}  // namespace
}  // namespace lcmslam
