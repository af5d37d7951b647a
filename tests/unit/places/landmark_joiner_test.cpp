#include <lcmslam/places/landmark_joiner.hpp>

#include <gmock/gmock.h>

#include "tests/support/landmark_room.hpp"

namespace lcmslam {
namespace {

using testing_scene::LandmarkRoom;

const Eigen::Isometry3d T_old_new = planar_pose(4, 1, -0.7);

class LandmarkJoinerTest : public ::testing::Test {
 protected:
  LandmarkJoinerTest() { map.add(room.mapped(Eigen::Isometry3d::Identity(), 1)); }
  static void expect_right(const Eigen::Isometry3d& T) {
    EXPECT_LT(distance_between(T, T_old_new), 0.03);
    EXPECT_LT(angle_between(T, T_old_new), 0.01);
  }

  LandmarkRoom room{1};
  LandmarkPlaces map;
  LandmarkJoiner joiner;
  const std::vector<Landmark> session = room.mapped(T_old_new.inverse(), 2);
};

TEST_F(LandmarkJoinerTest, JoinsWhenThreeGroupsAgree) {
  const auto group = [&](int number) {
    const auto begin = session.begin() + number * 60;
    return std::vector<Landmark>(begin, begin + 60);
  };
  joiner.add(group(0), map);
  joiner.add(group(3), map);
  EXPECT_FALSE(joiner.joint());
  joiner.add(group(5), map);
  ASSERT_TRUE(joiner.joint());
  expect_right(joiner.joint()->T_map_session);
  EXPECT_EQ(to_string(*joiner.joint()), "3 of 3 groups of landmarks were found and agree, 0 say otherwise");
}

TEST_F(LandmarkJoinerTest, GroupsOfOneViewAreOneLook) {
  for (std::uint64_t drive = 10; drive < 16; ++drive) {
    std::vector<Landmark> group = room.mapped(T_old_new.inverse(), drive, 0.3);
    group.resize(60);
    joiner.add(group, map);
  }
  EXPECT_FALSE(joiner.joint());
}

TEST_F(LandmarkJoinerTest, AWholeMapIsAskedGroupByGroup) {
  joiner.add_all(session, map);
  ASSERT_TRUE(joiner.joint());
  expect_right(joiner.joint()->T_map_session);
  EXPECT_EQ(joiner.joint()->asked, static_cast<int>(session.size() / 60));
  EXPECT_GE(joiner.joint()->agreeing, joiner.joint()->asked - 1);
  EXPECT_EQ(joiner.joint()->disagreeing, 0);
}

TEST_F(LandmarkJoinerTest, NobodyIsAskedForeverOnceEnoughAgree) {
  JoinSettings settings = LandmarkJoiner::defaults();
  settings.most_agreeing = 4;
  joiner = LandmarkJoiner(settings);
  joiner.add_all(session, map);
  ASSERT_TRUE(joiner.done());
  EXPECT_LT(joiner.joint()->asked, static_cast<int>(session.size() / 60));
}

// What was seen of the old map stays; where the session has its landmarks has changed.
TEST_F(LandmarkJoinerTest, FollowsWhereTheSessionsLandmarksGo) {
  const Eigen::Isometry3d bend = planar_pose(0.1, 0.05, 0.03);
  std::vector<Landmark> bent;
  for (const Landmark& landmark : session) bent.push_back(transformed(landmark, bend));
  joiner.add_all(bent, map);
  ASSERT_TRUE(joiner.joint());
  EXPECT_GT(distance_between(joiner.joint()->T_map_session, T_old_new), 0.05);
  const auto in = [](const std::vector<Landmark>& landmarks, std::size_t every) {
    return [&landmarks, every](std::int64_t id) {
      const auto i = static_cast<std::size_t>(id - landmarks.front().id);
      return i % every == 0 ? &landmarks.at(i) : nullptr;
    };
  };
  EXPECT_FALSE(joiner.move(in(bent, 1)));
  EXPECT_FALSE(joiner.move(in(session, 10))) << "too few are left to say where a group has gone";
  EXPECT_TRUE(joiner.move(in(session, 3)));
  expect_right(joiner.joint()->T_map_session);
  EXPECT_FALSE(joiner.move(in(session, 1))) << "it has followed";
}

TEST_F(LandmarkJoinerTest, ARoomThatLooksAlikeIsNotJoined) {
  joiner.add_all(LandmarkRoom(2).mapped(T_old_new.inverse(), 2), map);
  EXPECT_FALSE(joiner.joint());
  map.add(room.mapped(Eigen::Isometry3d::Identity(), 3), planar_pose(50, 0, 1));  // a twin
  joiner.add_all(session, map);
  EXPECT_FALSE(joiner.joint());
}

TEST_F(LandmarkJoinerTest, ARobotThatWasCarriedUnseenIsNotJoined) {
  std::vector<Landmark> slipped = session;
  for (std::size_t i = session.size() / 2; i < session.size(); ++i)
    slipped[i] = transformed(session[i], planar_pose(2, 1, 0.5));
  joiner.add_all(slipped, map);
  EXPECT_FALSE(joiner.joint());
}

}  // namespace
}  // namespace lcmslam
