#include <lcmslam/places/session_joiner.hpp>

#include <gmock/gmock.h>

#include "tests/unit/places/room.hpp"

namespace lcmslam {
namespace {

using testing_scene::Room;
using testing_scene::Seen;

const Eigen::Isometry3d T_map_session = planar_pose(4, 1, -0.7);

/// Poses of a session in the room, each some steps from the others.
std::vector<Eigen::Isometry3d> stops() {
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < 8; ++i) poses.push_back(Room::camera(2.7 + 0.08 * i, 2.4, 0.3 + 0.6 * i));
  return poses;
}

class SessionJoinerTest : public testing::Test {
 protected:
  SessionJoinerTest() { room.map(map); }

  /// A keyframe at a stop; `slip` displaces where the session believes it to be.
  void add(std::size_t stop, const Eigen::Isometry3d& slip = Eigen::Isometry3d::Identity()) {
    const Seen seen = room.seen_from(stops()[stop]);
    joiner.add(slip * T_map_session.inverse() * seen.T_room_camera, seen.features, seen.cloud, map,
               static_cast<std::int32_t>(stop));
  }

  Room room{1};
  PlaceIndex map;
  SessionJoiner joiner;
};

TEST_F(SessionJoinerTest, JoinsWhenThreeKeyframesAgree) {
  add(0);
  add(1);
  EXPECT_FALSE(joiner.joint());
  add(2);
  ASSERT_TRUE(joiner.joint());
  const Joint& joint = *joiner.joint();
  EXPECT_EQ(joint.agreeing, 3);
  EXPECT_EQ(joint.disagreeing, 0);
  EXPECT_EQ(joint.asked, 3);
  EXPECT_LT(distance_between(joint.T_map_session, T_map_session), 0.02);
  EXPECT_LT(angle_between(joint.T_map_session, T_map_session), 0.01);
  EXPECT_FALSE(joiner.done());
  EXPECT_EQ(to_string(joint), "3 of 3 keyframes were found and agree, 0 say otherwise");
}

TEST_F(SessionJoinerTest, OneLookRepeatedIsOneLook) {
  for (int i = 0; i < 5; ++i) add(0);
  EXPECT_FALSE(joiner.joint());
}

TEST_F(SessionJoinerTest, NobodyIsAskedForeverOnceEnoughAgree) {
  JoinSettings settings;
  settings.most_agreeing = 4;
  joiner = SessionJoiner(settings);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_FALSE(joiner.done());
    add(i);
  }
  EXPECT_TRUE(joiner.done());
}

TEST_F(SessionJoinerTest, ARoomThatLooksAlikeIsNotJoined) {
  Room other(2);
  for (const Eigen::Isometry3d& T : stops()) {
    const Seen seen = other.seen_from(T);
    joiner.add(T_map_session.inverse() * T, seen.features, seen.cloud, map);
  }
  EXPECT_FALSE(joiner.joint());
  room.map(map, planar_pose(50, 0, 1), 100);  // a twin
  for (std::size_t i = 0; i < stops().size(); ++i) add(i);
  EXPECT_FALSE(joiner.joint());
}

TEST_F(SessionJoinerTest, OneThatSaysOtherwiseMustBeOutvoted) {
  add(0, planar_pose(1, 0, 0));
  for (std::size_t i = 1; i <= 5; ++i) add(i);
  EXPECT_FALSE(joiner.joint());  // five against one
  add(6);
  ASSERT_TRUE(joiner.joint());
  EXPECT_EQ(joiner.joint()->agreeing, 6);
  EXPECT_EQ(joiner.joint()->disagreeing, 1);
  EXPECT_LT(distance_between(joiner.joint()->T_map_session, T_map_session), 0.02);
}

// The session's graph closes a loop: its keyframes move, and what they say with them.
TEST_F(SessionJoinerTest, FollowsTheSessionsOwnMap) {
  const Eigen::Isometry3d bend = planar_pose(0.05, 0.03, 0.02);
  std::map<std::int32_t, Eigen::Isometry3d> moved;
  for (std::size_t i = 0; i < 5; ++i) {
    add(i, bend);
    moved[static_cast<std::int32_t>(i)] = T_map_session.inverse() * room.seen_from(stops()[i]).T_room_camera;
  }
  ASSERT_TRUE(joiner.joint());
  EXPECT_GT(distance_between(joiner.joint()->T_map_session, T_map_session), 0.03);
  moved[77] = Eigen::Isometry3d::Identity();  // which was never asked
  joiner.move(moved);
  ASSERT_TRUE(joiner.joint());
  EXPECT_EQ(joiner.joint()->agreeing, 5);
  EXPECT_LT(distance_between(joiner.joint()->T_map_session, T_map_session), 0.02);
  EXPECT_LT(angle_between(joiner.joint()->T_map_session, T_map_session), 0.01);
}

// Its last three keyframes, which were a slip away, are given up: they neither outvote the others nor count.
TEST_F(SessionJoinerTest, WhatWasGivenUpSaysNothing) {
  for (std::size_t i = 0; i < 4; ++i) add(i);
  ASSERT_TRUE(joiner.joint());
  for (std::size_t i = 4; i < 7; ++i) add(i, planar_pose(2, 1, 0.5));
  EXPECT_FALSE(joiner.joint());
  joiner.drop({4, 5, 6, 77});
  ASSERT_TRUE(joiner.joint());
  EXPECT_EQ(joiner.joint()->agreeing, 4);
  EXPECT_EQ(joiner.joint()->disagreeing, 0);
  EXPECT_LT(distance_between(joiner.joint()->T_map_session, T_map_session), 0.02);
  joiner.drop({0, 1});
  EXPECT_FALSE(joiner.joint());  // two are too few
}

TEST_F(SessionJoinerTest, ARobotThatWasCarriedUnseenIsNotJoined) {
  for (std::size_t i = 0; i < 4; ++i) add(i);
  for (std::size_t i = 4; i < 8; ++i) add(i, planar_pose(2, 1, 0.5));
  EXPECT_FALSE(joiner.joint());
}

// The same looks in two frames of the session: one transform and one covariance, seen from each.
TEST_F(SessionJoinerTest, CovarianceBelongsToTheSessionsFrame) {
  const Eigen::Isometry3d T_other_session = planar_pose(-7, 12, 1.1) * Eigen::Translation3d(0, 0, 3);
  SessionJoiner other;
  for (std::size_t i = 0; i < 4; ++i) {
    const Seen seen = room.seen_from(stops()[i]);
    const Eigen::Isometry3d T_session_camera = T_map_session.inverse() * seen.T_room_camera;
    joiner.add(T_session_camera, seen.features, seen.cloud, map);
    other.add(T_other_session * T_session_camera, seen.features, seen.cloud, map);
  }
  ASSERT_TRUE(joiner.joint() && other.joint());
  const Matrix6d A = adjoint(T_other_session);
  const Matrix6d expected = A * joiner.joint()->covariance * A.transpose();
  EXPECT_LT((other.joint()->covariance - expected).norm(), 0.01 * expected.norm());
  const Eigen::Isometry3d moved = other.joint()->T_map_session * T_other_session;
  EXPECT_LT(distance_between(moved, joiner.joint()->T_map_session), 0.001);
  // Far from what was seen a small turn is a long way.
  EXPECT_GT(other.joint()->covariance(0, 0), 10 * joiner.joint()->covariance(0, 0));
}

TEST_F(SessionJoinerTest, SettingsAreChecked) {
  JoinSettings bad;
  bad.min_agreeing = 0;
  EXPECT_THROW(SessionJoiner{bad}, std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
