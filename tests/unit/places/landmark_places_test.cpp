#include <lcmslam/places/landmark_places.hpp>

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/support/landmark_room.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using testing_scene::LandmarkRoom;

const Eigen::Isometry3d T_session_room = Eigen::Translation3d(7, -2, 0.1) *
                                         Eigen::AngleAxisd(2.1, Eigen::Vector3d::UnitZ()) *
                                         Eigen::Isometry3d::Identity();
const Eigen::Isometry3d nowhere = Eigen::Isometry3d::Identity();

std::vector<Landmark> first(std::vector<Landmark> landmarks, std::size_t count) {
  landmarks.resize(std::min(count, landmarks.size()));
  return landmarks;
}

class LandmarkPlacesTest : public ::testing::Test {
 protected:
  LandmarkPlacesTest() { map.add(room.mapped(nowhere, 1)); }
  /// Of the session, from there on.
  std::vector<Landmark> group(double from = 0.2) const {
    return first(room.mapped(T_session_room, 2, from), 60);
  }
  static void expect_right(const LocatedGroup& located) {
    ASSERT_TRUE(located.place) << located.why_not;
    const Eigen::Isometry3d T_room_group = T_session_room.inverse() * located.T_session_group;
    const Eigen::Isometry3d error = T_room_group.inverse() * located.place->T_map_camera;
    EXPECT_LT(error.translation().norm(), 0.02);
    EXPECT_LT(rotation_angle(error), 0.03);
    const Vector6d xi = se3_log(error);
    EXPECT_LT(xi.dot(located.place->covariance.inverse() * xi), 22.46) << "99.9 % of six dimensions";
  }

  LandmarkRoom room{1};
  LandmarkPlaces map;
};

TEST_F(LandmarkPlacesTest, AGroupIsFoundWhereItIs) {
  for (const double from : {0.0, 0.3, 0.7}) {
    const LocatedGroup located = map.locate(group(from));
    expect_right(located);
    EXPECT_GT(located.inliers, 20);
    EXPECT_LT(located.other_inliers, 8);
    EXPECT_GT(located.share, 0.35);
    EXPECT_LT(located.place->covariance.diagonal().maxCoeff(), 0.001);
  }
}

TEST_F(LandmarkPlacesTest, MapsThatLieElsewhereAreAddedThere) {
  LandmarkPlaces other;
  other.add(room.mapped(planar_pose(-3, 5, 1), 1), planar_pose(-3, 5, 1).inverse());
  expect_right(other.locate(group()));
}

TEST_F(LandmarkPlacesTest, ASessionCanBeDropped) {
  const std::size_t size = map.size();
  const auto twin = planar_pose(20, 0, 0);
  map.add(room.mapped(nowhere, 3), twin, 7);
  EXPECT_FALSE(map.locate(group()).place) << "twins";
  map.drop(7);
  EXPECT_EQ(map.size(), size);
  expect_right(map.locate(group()));
  map.drop(0);
  EXPECT_EQ(map.size(), 0U);
}

// Else memory grows with each restart of a mapper that stays in one room.
TEST_F(LandmarkPlacesTest, WhatTwoSessionsHaveIsKeptTwice) {
  const std::size_t once = map.size();  // 0.6 of 900 things
  for (int session = 2; session < 8; ++session) map.add(room.mapped(nowhere, session), nowhere, session);
  const std::size_t seven = map.size();
  EXPECT_GT(seven, 2 * once);
  for (int session = 8; session < 20; ++session) map.add(room.mapped(nowhere, session), nowhere, session);
  EXPECT_LT(map.size(), seven + seven / 10);
  EXPECT_LT(map.size(), 2000U);
  expect_right(map.locate(group()));
  const std::size_t before = map.size();
  std::vector<Landmark> others = room.mapped(nowhere, 1);
  for (Landmark& l : others) std::rotate(l.descriptor.begin(), l.descriptor.begin() + 7, l.descriptor.end());
  map.add(others, nowhere, 20);  // other things at the same places
  EXPECT_EQ(map.size(), before + others.size());
  map.add(others, planar_pose(20, 0, 0), 21);  // and like ones elsewhere
  EXPECT_EQ(map.size(), before + 2 * others.size());
}

TEST_F(LandmarkPlacesTest, StrangersAreNotFound) {
  const LandmarkRoom other(2);
  for (const double from : {0.0, 0.3, 0.7})
    EXPECT_FALSE(map.locate(first(other.mapped(T_session_room, 2, from), 60)).place);
  EXPECT_THAT(map.locate({}).why_not, HasSubstr("only 0"));
}

TEST_F(LandmarkPlacesTest, TwinsAreNotToldApart) {
  map.add(room.mapped(nowhere, 3), planar_pose(30, 0, 1));
  const LocatedGroup located = map.locate(group());
  EXPECT_FALSE(located.place);
  EXPECT_THAT(located.why_not, HasSubstr("two places look alike"));
}

TEST_F(LandmarkPlacesTest, OnePosterIsNoPlace) {
  Random random(5);
  std::vector<Landmark> here, there;
  for (int i = 0; i < 40; ++i) {
    const Descriptor look = LandmarkRoom::any_look(random);
    const Eigen::Vector3d at(0.5 * random.uniform(), 0, 0.5 * random.uniform());
    here.push_back(LandmarkRoom::landmark(at, look, random));
    there.push_back(LandmarkRoom::landmark(T_session_room * at, look, random));
  }
  map.add(here);
  EXPECT_THAT(map.locate(there).why_not, HasSubstr("in one spot"));
}

TEST_F(LandmarkPlacesTest, ALineOfThemIsToldToBeOneAndNotToBeTooFew) {
  Random random(5);
  std::vector<Landmark> here, there;
  for (int i = 0; i < 40; ++i) {
    const Descriptor look = LandmarkRoom::any_look(random);
    const Eigen::Vector3d at(0, 0, 2 * random.uniform());
    here.push_back(LandmarkRoom::landmark(at, look, random));
    there.push_back(LandmarkRoom::landmark(T_session_room * at, look, random));
  }
  map.add(here);
  const LocatedGroup located = map.locate(there);
  EXPECT_FALSE(located.place);
  EXPECT_GE(located.inliers, LandmarkPlaceSettings().min_inliers);
  EXPECT_THAT(located.why_not, HasSubstr("on one line"));
}

TEST_F(LandmarkPlacesTest, WhatShouldBeThereAndIsNotSpeaksAgainstIt) {
  std::vector<Landmark> some = first(group(), 40);
  expect_right(map.locate(some));
  Random random(6);
  for (int i = 0; i < 200; ++i) {  // things that look otherwise, where the map was looked at
    Landmark stranger = some[static_cast<std::size_t>(i) % 40];
    stranger.descriptor = LandmarkRoom::any_look(random);
    some.push_back(stranger);
  }
  EXPECT_THAT(map.locate(some).why_not, HasSubstr("should be there"));
}

// How far the map as a whole may be off does not excuse that landmarks lie wildly.
TEST_F(LandmarkPlacesTest, AGroupIsRigidHoweverUncertainItsMap) {
  std::vector<Landmark> wild = group();
  Random random(7);
  for (Landmark& l : wild) {
    l.covariance = 0.25 * Eigen::Matrix3d::Identity();
    for (int k = 0; k < 3; ++k) l.mean[k] += 0.3 * random.normal();
  }
  EXPECT_FALSE(map.locate(wild).place);
  std::vector<Landmark> far = group();
  for (Landmark& l : far) l.covariance = 0.25 * Eigen::Matrix3d::Identity();
  expect_right(map.locate(far));
}

TEST_F(LandmarkPlacesTest, KnownIdentitiesHaveNoLooks) {
  LandmarkPlaces beacons;
  beacons.add(std::vector<Landmark>(5));
  EXPECT_EQ(beacons.size(), 0U);
  EXPECT_FALSE(map.locate(std::vector<Landmark>(60)).place);
}

TEST_F(LandmarkPlacesTest, SettingsAreChecked) {
  LandmarkPlaceSettings bad;
  bad.min_inliers = 0;
  EXPECT_THROW(LandmarkPlaces{bad}, std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
