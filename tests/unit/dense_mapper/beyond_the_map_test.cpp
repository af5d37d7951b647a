// Where the map ends, or is not what it was, or the robot may be anywhere in it.

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include "tests/support/cloud_scenes.hpp"
#include "tests/support/recorded_clouds.hpp"
#include "tests/support/room_view.hpp"
#include "tests/unit/dense_mapper/drive.hpp"

namespace lcmslam {
namespace {

// Another room behind the robot that looks the same: odometry tells them apart, and is believed where the
// map ends. As long as nothing else ties what is mapped there to the map, nobody claims to track in it.
TEST(BeyondTheMap, GoesOnFromOdometryWhereTheMapEnds) {
  DenseMapperSettings settings;
  settings.reseed_after = 3;
  DenseMapper mapper(settings);
  mapper.step(coloured_frame(0, seen_from(room(0.03), no_mount, 1), no_mount));
  const Eigen::Isometry3d T = planar_pose(0, 0, 3.0);
  Motion motion;
  motion.T_from_to = T;
  motion.covariance = 1e-4 * Matrix6d::Identity();
  const ColouredCloud behind = seen_from(transformed(room(0.03), T), T, 2);
  DenseMapper::Step step;
  for (int i = 1; i <= 8; ++i) {
    SCOPED_TRACE(i);
    step = mapper.step(coloured_frame(i * frame_time, behind, no_mount, motion));
    const bool waiting = i <= settings.reseed_after;
    EXPECT_EQ(to_string(step.status), waiting ? "lost" : "degraded");
    EXPECT_EQ(step.hangs_on_odometry, !waiting);
    if (waiting) {
      EXPECT_GE(step.map_covariance(0, 0), 0.99 * step.covariance(0, 0)) << "as lost in the map";
    }
    const double known = (settings.reseed_after + 1) * 1e-4 + std::pow(settings.prior.floor_translation, 2);
    if (i == settings.reseed_after + 1) {
      EXPECT_TRUE(step.reseeded);
      EXPECT_NEAR(step.covariance(0, 0), known, 1e-9) << "of all motion since the map was left";
    }
    if (!waiting) {
      EXPECT_GT(step.map_covariance(0, 0), 0.99 * known) << "all that is mapped from there";
      EXPECT_LT(step.map_covariance(0, 0), 1.5 * known);
    }
    motion.T_from_to.setIdentity();
  }
  expect_pose(step.T_world_robot, T, 0.02, 0.02);
  EXPECT_GT(step.quality, 0.5) << "of what was mapped from there";

  // Back at the start the graph compares both.
  motion.T_from_to = T.inverse();
  for (int i = 9; i <= 20; ++i) {
    const ColouredCloud before = seen_from(room(0.03), no_mount, static_cast<std::uint64_t>(i));
    step = mapper.step(coloured_frame(i * frame_time, before, no_mount, motion));
    motion.T_from_to.setIdentity();
  }
  EXPECT_EQ(to_string(step.status), "tracking");
  EXPECT_FALSE(step.hangs_on_odometry);
  expect_pose(step.T_world_robot, no_mount, 0.02, 0.02);
}

/// Its walls are half as far away.
Cloud nearer_room() {
  Cloud nearer = room(0.015);
  for (Eigen::Vector3f& p : nearer.points) p *= 0.5f;
  return nearer;
}

/// It stands in a room that it has seen, says its visual odometry; the walls come nearer.
class StandingRobot : public ::testing::Test {
 protected:
  StandingRobot() {
    still_.visual = true;
    still_.covariance = 1e-6 * Matrix6d::Identity();
    look(seen_from(room(0.03), no_mount, 1));
  }
  static DenseMapperSettings settings() {
    DenseMapperSettings settings;
    settings.reseed_after = 3;
    return settings;
  }
  DenseMapper::Step look(const ColouredCloud& seen) {
    return mapper_.step(coloured_frame(frame_time * frames_++, seen, no_mount, still_));
  }

  DenseMapper mapper_{settings()};
  const ColouredCloud changed_ = seen_from(nearer_room(), no_mount, 3);

 private:
  Motion still_;
  int frames_ = 0;
};

// What a covered camera does not show is no sign that the map has ended.
TEST_F(StandingRobot, HasNoReasonToGoOnFromOdometryWhileItsCameraIsCovered) {
  for (int i = 0; i < 6; ++i) EXPECT_TRUE(look(ColouredCloud()).blind);
  for (int i = 0; i <= settings().reseed_after; ++i)
    EXPECT_EQ(look(changed_).reseeded, i == settings().reseed_after) << i;
}

// From then on it knows them.
TEST_F(StandingRobot, MapsWhatHasChangedOnce) {
  int reseeded = 0;
  for (int i = 1; i <= 20; ++i) {
    const DenseMapper::Step step = look(changed_);
    reseeded += step.reseeded ? 1 : 0;
    EXPECT_EQ(to_string(step.status), reseeded > 0 ? "degraded" : "lost") << i;
  }
  EXPECT_EQ(reseeded, 1);
}

/// Its walls are farther away, and so high or low that the old ones are looked through.
Cloud farther_room() {
  Cloud farther = room(0.03);
  for (Eigen::Vector3f& p : farther.points) p *= 2.0f;
  return farther;
}

// Odometry may have led it elsewhere: that it looks through what has been mapped before says nothing.
TEST(BeyondTheMap, WhatHangsOnOdometryTakesNothingFromTheMapBefore) {
  DenseMapperSettings settings;
  settings.reseed_after = 3;
  settings.free_space.rotation = 1;
  DenseMapper mapper(settings);
  const Eigen::Isometry3d mount = optical_axes();
  Motion still;
  still.visual = true;
  still.covariance = 1e-6 * Matrix6d::Identity();
  Utime utime = 0;
  const auto look = [&](const Cloud& scene) {
    return mapper.step(coloured_frame(utime += frame_time, seen_from(scene, mount, 1), mount, still));
  };
  look(room(0.03));
  const Cloud before = mapper.map().cloud();
  DenseMapper::Step step;
  for (int i = 0; i < 30; ++i) step = look(farther_room());
  ASSERT_TRUE(step.hangs_on_odometry);
  std::size_t left = 0;
  TargetPoint found;
  for (const Eigen::Vector3f& p : before.points) left += mapper.map().find(p, 0.02f, found) ? 1 : 0;
  EXPECT_EQ(left, before.size());
}

// A little aside of a keyframe the walls have come nearer while it was away: what is mapped there is as
// uncertain as odometry, not as that keyframe.
TEST(BeyondTheMap, WhatOdometryPlacedBelongsToANodeOfItsOwn) {
  DenseMapperSettings settings;
  settings.reseed_after = 3;
  settings.keyframe_overlap = 0;  // so near no new keyframe is made, however little overlaps
  DenseMapper mapper(settings);
  mapper.step(coloured_frame(0, seen_from(room(0.03), no_mount, 1), no_mount));
  Motion motion;
  motion.T_from_to.translation().x() = 0.9 * settings.keyframe_distance;
  motion.covariance = 1e-4 * Matrix6d::Identity();
  const ColouredCloud aside = seen_from(room(0.03), motion.T_from_to, 2);
  EXPECT_EQ(to_string(mapper.step(coloured_frame(frame_time, aside, no_mount, motion)).status), "tracking");
  ASSERT_EQ(mapper.graph().nodes().size(), 1U);

  motion.T_from_to.translation().x() = -1.1 * settings.keyframe_distance;
  DenseMapper::Step step;
  for (int i = 0; i <= settings.reseed_after; ++i) {
    step = mapper.step(
        coloured_frame((2 + i) * frame_time, seen_from(nearer_room(), no_mount, 3), no_mount, motion));
    motion.T_from_to.setIdentity();
  }
  ASSERT_TRUE(step.reseeded);
  EXPECT_EQ(mapper.graph().nodes().size(), 2U);
  EXPECT_GT(step.map_covariance(0, 0), std::pow(settings.prior.floor_translation, 2));
}

// After a gap it may be anywhere, also where its cloud happens to fit.
TEST(BeyondTheMap, ARobotThatMayBeAnywhereSaysSo) {
  DenseMapper mapper{DenseMapperSettings()};
  const ColouredCloud seen = seen_from(room(0.03), no_mount, 1);
  mapper.step(coloured_frame(0, seen, no_mount));
  const double gap = 5;  // s without frames and odometry
  const auto begin = static_cast<Utime>(1e6 * gap);
  double before = 0;
  for (int i = 0; i < 3; ++i) {
    const DenseMapper::Step step = mapper.step(coloured_frame(begin + i * frame_time, seen, no_mount));
    ASSERT_TRUE(step.adrift);
    EXPECT_FALSE(step.carried);
    EXPECT_EQ(to_string(step.status), "lost");
    EXPECT_GT(step.covariance(0, 0), 0.25 * gap * gap) << "half a metre a second";
    EXPECT_GE(step.map_covariance(0, 0), step.covariance(0, 0));
    EXPECT_GE(step.covariance(0, 0), before);
    before = step.covariance(0, 0);
  }
}

/// Its wheels stand still, and another room is there.
class CarriedRobot : public ::testing::Test {
 protected:
  CarriedRobot() { still_.covariance = 1e-6 * Matrix6d::Identity(); }

  /// It has seen the first room once.
  void map_first_room(const DenseMapperSettings& settings) {
    mapper_.emplace(settings);
    mapper_->step(coloured_frame(0, seen_from(room(0.03), no_mount, 1), no_mount));
  }
  DenseMapper::Step look() {
    return mapper_->step(coloured_frame(++frames_ * frame_time, there_, no_mount, still_));
  }
  DenseMapper::Step look_at_first_room() {
    const ColouredCloud seen = seen_from(room(0.03), no_mount, 3);
    return mapper_->step(coloured_frame(++frames_ * frame_time, seen, no_mount, still_));
  }

  Motion still_;

 private:
  std::optional<DenseMapper> mapper_;
  const ColouredCloud there_ = seen_from(transformed(room(0.03), planar_pose(0.3, 0.2, 3.0)), no_mount, 2);
  int frames_ = 0;
};

TEST_F(CarriedRobot, SaysThatItMayBeAnywhere) {
  const DenseMapperSettings settings;
  map_first_room(settings);
  DenseMapper::Step step;
  for (int i = 1; i < 50 && !step.adrift; ++i) step = look();
  ASSERT_TRUE(step.adrift);
  EXPECT_TRUE(step.carried);
  EXPECT_GT(step.covariance(0, 0), 0.25 * settings.carried_after * settings.carried_after);
}

// Who never takes a robot for carried must not wait for the day that it is carried back.
TEST_F(CarriedRobot, GoesOnFromOdometryWhereNobodyWatches) {
  DenseMapperSettings settings;
  settings.carried_after = 0;
  settings.reseed_after = 5;
  map_first_room(settings);
  for (int i = 1; i <= settings.reseed_after + 1; ++i) {
    const DenseMapper::Step step = look();
    EXPECT_FALSE(step.adrift || step.carried);
    EXPECT_EQ(step.reseeded, i == settings.reseed_after + 1) << i;
  }
}

// Odometry by wheels gives way to that of a camera, which says nothing of who is carried.
TEST_F(CarriedRobot, IsNotContradictedByWheelsThatAreSilent) {
  DenseMapperSettings settings;
  settings.reseed_after = 5;
  map_first_room(settings);
  look();
  still_.visual = true;
  bool reseeded = false;
  for (int i = 0; i <= settings.reseed_after; ++i) reseeded |= look().reseeded;
  EXPECT_TRUE(reseeded);
}

// Its wheels stand still, and a door opens: another room, deep and low, but the walls beside the door are
// where they were. It maps what it sees there.
TEST(BeyondTheMap, ARobotBeforeADoorThatOpensHasNotBeenCarried) {
  DenseMapperSettings settings;
  DenseMapper mapper(settings);
  Cloud walls, beyond;
  add_rectangle(walls, {1, -1.5, -1}, {0, 0, 2}, {2, 0, 0}, 0.03);
  add_rectangle(walls, {3, -1.5, -1}, {0, 0, 2}, {0, 0.5, 0}, 0.03);
  Cloud shut = walls, open = walls;
  add_rectangle(shut, {3, -1, -1}, {0, 0, 2}, {0, 4, 0}, 0.03);
  add_rectangle(open, {3, -3, -2}, {5, 0, 0}, {0, 6, 0}, 0.04);
  add_rectangle(open, {8, -1.5, -1}, {0, 0, 2}, {0, 3, 0}, 0.04);
  Motion still;
  still.covariance = 1e-6 * Matrix6d::Identity();
  mapper.step(coloured_frame(0, seen_from(shut, no_mount, 1), no_mount));
  DenseMapper::Step step;
  for (int i = 1; i < 40; ++i) {
    step = mapper.step(coloured_frame(i * frame_time, seen_from(open, no_mount, 2), no_mount, still));
    EXPECT_FALSE(step.adrift) << i;
  }
  EXPECT_TRUE(step.hangs_on_odometry);
  EXPECT_GT(step.quality, 0.5) << "of what it has mapped beyond";
  expect_pose(step.T_world_robot, no_mount, 0.02, 0.01);
}

/// Its wheels stand, and it looks along x into the room that it has seen once.
class BlockedRobot : public ::testing::Test {
 protected:
  BlockedRobot() { look(room(0.03)); }
  DenseMapper::Step look(const Cloud& scene) {
    Motion still;
    still.covariance = 1e-6 * Matrix6d::Identity();
    const ColouredCloud seen = seen_from(scene, optical_axes(), static_cast<std::uint64_t>(++frames_));
    return mapper_.step(coloured_frame(frames_ * frame_time, seen, optical_axes(), still));
  }
  void expect_carried_within_a_second(const Cloud& elsewhere) {
    DenseMapper::Step step;
    int frames = 0;
    while (frames < 30 && !step.carried) {
      step = look(elsewhere);
      EXPECT_FALSE(step.blocked);
      ++frames;
    }
    EXPECT_TRUE(step.carried);
    EXPECT_LE(frames, 11);
  }
  /// A surface before all of the view but its outermost `free` to one side (m, at 0.8 m).
  static Cloud somebody_close(double free = 0) {
    Cloud close;
    add_rectangle(close, {0.8, -1.2, -1.2}, {0, 0, 2.4}, {0, 2.4 - free, 0}, 0.015);
    return close;
  }

  DenseMapper mapper_;

 private:
  int frames_ = 0;
};

TEST_F(BlockedRobot, StaysWhereItsWheelsStand) {
  const std::size_t surfels = mapper_.map().size();
  const double floor = 0.1 * MotionPriorSettings().floor_translation;  // of wheels that stand
  for (int i = 1; i <= 80; ++i) {
    SCOPED_TRACE(i);
    const DenseMapper::Step step = look(somebody_close());
    EXPECT_TRUE(step.blocked);
    EXPECT_FALSE(step.adrift || step.carried || step.reseeded);
    EXPECT_EQ(to_string(step.status), "degraded");
    EXPECT_EQ(step.unplaced, 0);
    expect_pose(step.T_world_robot, no_mount, 1e-6, 1e-6);
    EXPECT_NEAR(step.covariance(0, 0), i * 1e-6 + floor * floor, 1e-8) << "as odometry";
  }
  EXPECT_EQ(mapper_.map().size(), surfels) << "who stands there is no map";
  const DenseMapper::Step step = look(room(0.03));
  EXPECT_EQ(to_string(step.status), "tracking");
  EXPECT_FALSE(step.blocked || step.relocalised);
  expect_pose(step.T_world_robot, no_mount, 0.01, 0.01);
}

// Or rolls on where nothing counts its wheels: what fits a little beside where they stand is the map, seen
// from there, and no other place.
TEST_F(BlockedRobot, FollowsAPush) {
  const Eigen::Isometry3d there = planar_pose(0.05, -0.04, 0.05);
  DenseMapper::Step step;
  for (int i = 1; i <= 20; ++i) {
    SCOPED_TRACE(i);
    step = look(transformed(room(0.03), there.inverse()));
    EXPECT_EQ(to_string(step.status), "tracking");
    EXPECT_FALSE(step.hangs_on_odometry);
    expect_pose(step.T_world_robot, there, 0.02, 0.02);
  }
  expect_pose(step.T_world_robot, there, 0.01, 0.01);
  expect_pose(step.T_local_robot, there, 0.02, 0.02);
}

// Beside what is nearer there is something farther where the map has a wall, a floor and a box.
TEST_F(BlockedRobot, WasCarriedWhereItLooksThroughTheMapAsWell) {
  Cloud elsewhere = somebody_close(1);
  add_rectangle(elsewhere, {5, 1.25, -7.5}, {0, 0, 15}, {0, 6.25, 0}, 0.09);  // in all of what is free
  for (int i = 1; i <= 10; ++i) look(somebody_close());
  expect_carried_within_a_second(elsewhere);
}

// A wall before all of the view stands too far away to have come by itself.
TEST_F(BlockedRobot, WasCarriedWhereAWallIsNearer) {
  Cloud elsewhere = somebody_close();
  for (Eigen::Vector3f& p : elsewhere.points) p *= 1.6f;
  expect_carried_within_a_second(elsewhere);
}

/// It has seen a place, has driven on from there by its wheels, and looks at it again after a gap in all that
/// is heard, without features.
class FoundAgain : public ::testing::Test {
 protected:
  FoundAgain() {
    Motion on;
    on.covariance = 1e-6 * Matrix6d::Identity();
    look(no_mount, 0.1, {});
    on.T_from_to = planar_pose(-0.2, 0.1, 0);
    for (int i = 1; i <= 4; ++i) look(planar_pose(-0.2 * i, 0.1 * i, 0), 0.1, on);
  }
  DenseMapper::Step look(const Eigen::Isometry3d& T_world_robot, double seconds_later,
                         const std::optional<Motion>& motion) {
    utime_ += static_cast<Utime>(1e6 * seconds_later);
    const ColouredCloud seen = seen_from(room(0.03), T_world_robot, static_cast<std::uint64_t>(++frames_));
    last_ = mapper_.step(coloured_frame(utime_, seen, no_mount, motion));
    return last_;
  }
  /// Frames until it is found where it began.
  int look_until_found(double interval) {
    look(no_mount, 5, std::nullopt);
    int frames = 1;
    for (; frames < 30 && last_.adrift; ++frames) look(no_mount, interval, std::nullopt);
    return frames;
  }

  DenseMapper mapper_;
  DenseMapper::Step last_;

 private:
  Utime utime_ = 0;
  int frames_ = 0;
};

// The candidates before have led to where it is found: it has not driven there for that.
TEST_F(FoundAgain, FarFromWhereItWasLostItIsRelocalised) {
  ASSERT_EQ(to_string(last_.status), "tracking");
  const int last_node = mapper_.graph().nodes().back().id;
  look_until_found(0.1);
  EXPECT_EQ(to_string(last_.status), "tracking");
  expect_pose(last_.T_world_robot, no_mount, 0.02, 0.02);
  EXPECT_TRUE(last_.relocalised);
  ASSERT_GT(mapper_.graph().nodes().back().id, last_node);
  EXPECT_EQ(mapper_.graph().edges().back().from, 0) << "tied to what it sees, not to where it was lost";
  EXPECT_FALSE(look(no_mount, 0.1, std::nullopt).relocalised) << "once";
}

TEST_F(FoundAgain, ASlowCameraNeedsFewerFrames) {
  EXPECT_EQ(look_until_found(0.6), 3);
}
TEST_F(FoundAgain, AFastCameraNeedsManyFrames) {
  EXPECT_EQ(look_until_found(0.05), DenseMapperSettings().reseed_after + 1);
}

// Without features a place counts after some frames: until then it is one that may be right.
TEST_F(CarriedRobot, IsNotWithoutAPlaceInTheMapWhileWhatItSeesFits) {
  map_first_room({});
  double unplaced = 0;
  for (int i = 1; i < 50 && unplaced < 1; ++i) unplaced = look().unplaced;
  ASSERT_GE(unplaced, 1);
  for (int i = 0; i < 5; ++i) {
    const DenseMapper::Step back = look_at_first_room();
    EXPECT_TRUE(back.adrift);
    EXPECT_EQ(back.unplaced, 0) << i;
  }
  EXPECT_NEAR(look().unplaced, unplaced + 0.1, 1e-6) << "the others have shown no place";
}

}  // namespace
}  // namespace lcmslam
