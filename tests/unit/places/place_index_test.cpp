#include <lcmslam/places/place_index.hpp>

#include <gmock/gmock.h>

#include "tests/unit/places/room.hpp"

namespace lcmslam {
namespace {

using testing::HasSubstr;
using testing_scene::Room;
using testing_scene::Seen;

/// Beside the tour's keyframes.
const Eigen::Isometry3d asked_from = Room::camera(3.3, 2.9, 0.75);

const Eigen::Isometry3d far_away = planar_pose(40, -20, 2);

void expect_at(const Located& located, const Eigen::Isometry3d& T_map_camera) {
  ASSERT_TRUE(located.place) << located.why_not;
  EXPECT_EQ(located.why_not, "");
  EXPECT_LT(distance_between(located.place->T_map_camera, T_map_camera), 0.01);
  EXPECT_LT(angle_between(located.place->T_map_camera, T_map_camera), 0.006);
}

class PlaceIndexTest : public testing::Test {
 protected:
  PlaceIndexTest() { room.map(index); }
  Located ask(const Seen& seen) { return index.locate(seen.features, seen.cloud); }
  /// So many keyframes in rows of `side`, all looking the way that the asker does.
  void map_well(int side, double apart, double x, double y) {
    for (int row = 0; row < side; ++row)
      for (int column = 0; column < side; ++column) {
        const Seen seen = room.seen_from(Room::camera(x + apart * column, y + apart * row, 0.75));
        index.add(200 + row * side + column, seen.T_room_camera, seen.features, seen.cloud);
      }
  }

  Room room{1};
  PlaceIndex index;
  Seen asker = room.seen_from(asked_from);
};

TEST_F(PlaceIndexTest, FindsAViewBesideItsKeyframesAndSaysWhy) {
  const Located located = ask(asker);
  expect_at(located, asked_from);
  const PlaceEvidence& e = located.evidence;
  EXPECT_GE(e.inliers, 30);
  EXPECT_THAT(e.keyframes, testing::Contains(1));
  EXPECT_EQ(e.other_inliers, 0);
  EXPECT_GT(e.overlap, 0.7);
  EXPECT_GT(e.inlier_share, 0.8);
  EXPECT_GT(e.rms, 0);
  EXPECT_LT(e.rms, 0.015);
  EXPECT_LT(e.seen_through, 0.03);
  EXPECT_GT(e.agrees, 0.95);
  EXPECT_THAT(to_string(e), HasSubstr(std::to_string(e.inliers) + " features"));
}

TEST_F(PlaceIndexTest, TheSameQuestionHasTheSameAnswer) {
  const Located first = ask(asker), again = ask(asker);
  ASSERT_TRUE(first.place && again.place);
  EXPECT_EQ(first.place->T_map_camera.matrix(), again.place->T_map_camera.matrix());
}

TEST_F(PlaceIndexTest, AnotherRoomIsNowhere) {
  const Located located = ask(Room(2).seen_from(asked_from));
  EXPECT_FALSE(located.place);
  EXPECT_NE(located.why_not, "");
}

TEST_F(PlaceIndexTest, TwinRoomsAreToldApartByNobodyUntilOneIsDropped) {
  room.map(index, far_away, 100);
  Located located = ask(asker);
  EXPECT_FALSE(located.place);
  EXPECT_THAT(located.why_not, HasSubstr("two places look alike"));
  EXPECT_GT(2 * located.evidence.other_inliers, located.evidence.inliers);
  for (std::int64_t key = 0; key < 12; ++key) index.drop(key);
  expect_at(ask(asker), far_away * asked_from);
}

// More of its keyframes than are matched at once look like the asker: those that are left say the same place
// again.
TEST_F(PlaceIndexTest, ATwinRoomIsSeenHoweverOftenTheFirstWasMapped) {
  map_well(4, 0.2, 2.7, 2.5);
  expect_at(ask(asker), asked_from);
  room.map(index, far_away, 100);
  const Located located = ask(asker);
  EXPECT_FALSE(located.place);
  EXPECT_THAT(located.why_not, HasSubstr("two places look alike"));
}

// All votes go to the keyframes of the first room: there are more than neighbours are asked for.
TEST_F(PlaceIndexTest, ATwinRoomOfFewKeyframesIsSeenBesideOneOfMany) {
  map_well(7, 0.3, 2.4, 2);
  expect_at(ask(asker), asked_from);
  for (int i = 0; i < 3; ++i) {
    const Seen seen = room.seen_from(Room::camera(3.2 + 0.2 * i, 2.8, 0.75));
    index.add(100 + i, far_away * seen.T_room_camera, seen.features, seen.cloud);
  }
  const Located located = ask(asker);
  EXPECT_FALSE(located.place);
  EXPECT_THAT(located.why_not, HasSubstr("two places look alike"));
}

TEST_F(PlaceIndexTest, WhatAnotherMapFoundIsNoPlaceWhereThisOneHasItsTwin) {
  const Eigen::Isometry3d T_map_other = planar_pose(-3, 5, 1);
  PlaceIndex other;
  room.map(other);
  Located located = other.locate(asker.features, asker.cloud);
  index.look_for_twin(asker.features, Eigen::Isometry3d::Identity(), located);  // the same place
  expect_at(located, asked_from);
  index.look_for_twin(asker.features, T_map_other, located);
  EXPECT_FALSE(located.place);
  EXPECT_THAT(located.why_not, HasSubstr("two places look alike"));
  index.look_for_twin(asker.features, T_map_other, located);  // it is none any more
  EXPECT_FALSE(located.place);
}

TEST_F(PlaceIndexTest, KeyframesMoveGoAndAreReplaced) {
  const auto poses = Room::tour();
  for (std::size_t i = 0; i < poses.size(); ++i)
    index.move(static_cast<std::int64_t>(i), far_away * poses[i]);
  index.move(99, far_away);  // not there
  expect_at(ask(asker), far_away * asked_from);
  room.map(index);  // the same keys
  EXPECT_EQ(index.size(), poses.size());
  expect_at(ask(asker), asked_from);
  for (std::int64_t key = 0; key < 12; ++key) index.drop(key);
  index.drop(99);
  EXPECT_EQ(index.size(), 0U);
  EXPECT_FALSE(index.has(0));
  EXPECT_THAT(ask(asker).why_not, HasSubstr("no keyframe"));
  room.map(index);
  EXPECT_TRUE(index.has(0));
  expect_at(ask(asker), asked_from);
}

TEST_F(PlaceIndexTest, WhatWentLeavesItsRoomToOthers) {
  const std::size_t before = index.memory_bytes();
  for (int i = 0; i < 500; ++i) index.add(0, asked_from, asker.features, {});
  EXPECT_LT(index.memory_bytes(), before + before / 20);
}

// Else memory grows with each restart of a mapper that stays in one room.
TEST_F(PlaceIndexTest, OfAPlaceThatIsMappedAgainAndAgainTheFirstAndTheLastStay) {
  const std::size_t tour = index.size();
  constexpr int sessions = 9;
  for (int s = 1; s < sessions; ++s) {
    const Eigen::Isometry3d beside = planar_pose(0.01 * s, -0.01 * s, 0.01 * s);
    for (std::size_t i = 0; i < tour; ++i) {
      const Eigen::Isometry3d T_room_camera = Room::tour()[i] * beside;
      const Seen seen = room.seen_from(T_room_camera);
      index.add(100 * s + static_cast<std::int64_t>(i), T_room_camera, seen.features, seen.cloud);
    }
  }
  EXPECT_LE(index.size(), 4 * tour);
  for (const std::int64_t key : {0, 101, 701, 801}) EXPECT_TRUE(index.has(key)) << key;
  EXPECT_FALSE(index.has(401));
  expect_at(ask(asker), asked_from);
}

TEST_F(PlaceIndexTest, FeaturesWithoutACloudWillDo) {
  const Located located = index.locate(asker.features);
  ASSERT_TRUE(located.place) << located.why_not;
  EXPECT_LT(distance_between(located.place->T_map_camera, asked_from), 0.02);
}

TEST_F(PlaceIndexTest, WhoSeesLittleIsNowhere) {
  EXPECT_THAT(index.locate({}).why_not, HasSubstr("only 0 features"));
  Seen few = asker;
  few.features.features.resize(10);
  EXPECT_THAT(ask(few).why_not, HasSubstr("only 10 features"));
  Seen flat = asker;
  for (Feature& f : flat.features.features) f.kind = MeasurementKind::bearing;
  EXPECT_THAT(ask(flat).why_not, HasSubstr("only 0 features"));
  Seen without_camera = asker;
  without_camera.features.fx = 0;
  EXPECT_FALSE(ask(without_camera).place);
}

TEST_F(PlaceIndexTest, OnePosterIsNoPlace) {
  Seen poster = asker;
  auto& features = poster.features.features;
  features.erase(
      std::remove_if(features.begin(), features.end(),
                     [](const Feature& f) { return f.x < 250 || f.x > 390 || f.y < 100 || f.y > 380; }),
      features.end());
  for (Feature& f : features) f.x = 320 + 0.3F * (f.x - 320);
  ASSERT_GE(features.size(), 14U);
  EXPECT_THAT(ask(poster).why_not, HasSubstr("one spot"));
}

TEST_F(PlaceIndexTest, PointsOnALineAreToldToBeOnOneAndNotToBeTooFew) {
  auto& features = asker.features.features;
  features.resize(40);
  Random random(3);
  for (std::size_t i = 0; i < features.size(); ++i) {
    const float across = 0.03F * static_cast<float>(i) - 0.6F;
    features[i].point = {across, 0, 2 + 0.004F * static_cast<float>(random.normal())};
    features[i].x = static_cast<float>(asker.features.cx + asker.features.fx * across / 2);
    features[i].y = static_cast<float>(asker.features.cy + 0.5 * random.normal());
  }
  index.add(500, asked_from, asker.features, {});
  const Located located = index.locate(asker.features);
  EXPECT_FALSE(located.place);
  EXPECT_GE(located.evidence.inliers, PlaceSettings().min_inliers);
  EXPECT_THAT(located.why_not, HasSubstr("on one line"));
}

TEST_F(PlaceIndexTest, FeaturesInTheWrongOrderAreNoPlace) {
  auto& features = asker.features.features;
  const std::vector<Feature> before = features;
  for (std::size_t i = 0; i < features.size(); ++i)
    features[i].point = before[(7 * i + 3) % before.size()].point;
  EXPECT_THAT(ask(asker).why_not, HasSubstr("points lie alike"));
}

TEST_F(PlaceIndexTest, SurfacesMustLieWhereTheFeaturesSay) {
  Seen elsewhere = asker;
  for (std::size_t i = 0; i < elsewhere.cloud.size(); ++i)
    if (i % 5 != 0) elsewhere.cloud.points[i] *= 0.5F;
  EXPECT_THAT(ask(elsewhere).why_not, HasSubstr("nearer or farther"));
  EXPECT_LT(ask(elsewhere).evidence.agrees, 0.4);
  Seen unlike = asker;
  for (auto& p : unlike.cloud.points) p *= 1.5F;
  EXPECT_THAT(ask(unlike).why_not, HasSubstr("surfaces do not"));
  Seen shifted = asker;
  for (auto& p : shifted.cloud.points) p += Eigen::Vector3f(0, 0, 0.14F);
  EXPECT_THAT(ask(shifted).why_not, HasSubstr("different poses"));
}

/// A depth camera's own errors, of which more points know no more: far surfaces 4 cm beside.
TEST_F(PlaceIndexTest, SurfacesThatErrDoNotOverruleFeatures) {
  Random random(4);
  for (Eigen::Vector3f& p : asker.cloud.points)
    p += Eigen::Vector3f(0.04f, 0, 0) + p.normalized() * static_cast<float>(random.normal(0, 0.02));
  const Located located = ask(asker);
  ASSERT_TRUE(located.place) << located.why_not;
  const Vector6d error = se3_log(located.place->T_map_camera.inverse() * asked_from);
  EXPECT_LT(error.head<3>().norm(), 0.018);  // of 0.04: surfaces alone that are believed say 0.022
  EXPECT_LT(error.dot(located.place->covariance.inverse() * error), 16.8);  // 99 % of chi-square
}

TEST_F(PlaceIndexTest, NobodySeesThroughTheMap) {
  // The same room, but where the map was made something large stood before the wall.
  PlaceIndex furnished;
  Room full(1);
  full.scene.boxes.emplace_back(Eigen::Vector3d(4.3, 3.2, 0), Eigen::Vector3d(4.6, 4.2, 1.6));
  full.map(furnished);
  const Located located = furnished.locate(asker.features, asker.cloud);
  EXPECT_FALSE(located.place);
  EXPECT_THAT(located.why_not, HasSubstr("sees through"));
  EXPECT_GT(located.evidence.seen_through, 0.15);
}

TEST_F(PlaceIndexTest, SettingsAreChecked) {
  PlaceSettings bad;
  bad.min_margin = 0;
  EXPECT_THROW(PlaceIndex{bad}, std::invalid_argument);
}

// Errors against what the covariance says of them, over maps and askers with new noise: 6 if all noise is
// what it is said to be. Registration counts neighbouring pixels as one, which here are independent: it may
// be less.
TEST(PlaceIndexCovariance, IsNotTooSureNorFarTooUnsure) {
  PlaceSettings settings;
  settings.floor_translation = settings.floor_rotation = 0;
  double nees = 0;
  constexpr int seeds = 20;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Room room(1, seed);
    PlaceIndex index(settings);
    room.map(index);
    const Seen asker = room.seen_from(asked_from);
    const Located located = index.locate(asker.features, asker.cloud);
    ASSERT_TRUE(located.place) << "seed " << seed << ": " << located.why_not;
    const Vector6d error = se3_log(located.place->T_map_camera.inverse() * asked_from);
    nees += error.dot(located.place->covariance.inverse() * error) / seeds;
  }
  EXPECT_LT(nees, 6);
  EXPECT_GT(nees, 0.4);
}

}  // namespace
}  // namespace lcmslam
