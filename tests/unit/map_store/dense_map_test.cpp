#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/map_store/dense_map.hpp>
#include "tests/unit/map_store/sample_map.hpp"

namespace lcmslam {
namespace {

using testing::ElementsAre;

KeyframeTile tile(std::int32_t id, int index, int count, std::uint64_t seed, bool normals = true) {
  KeyframeTile result;
  result.part.id = id;
  result.part.utime = 1000 * id;
  result.part.cloud = random_cloud(seed, 50, normals);
  result.tile = index;
  result.tiles = count;
  return result;
}

TEST(DenseMap, TilesComeInAnyOrderAndRepeatedly) {
  std::vector<int> order = {0, 1, 2};
  do {
    DenseMap map;
    for (std::size_t i = 0; i < 3; ++i) {
      const KeyframeTile part = tile(4, order[i], 3, 10 + static_cast<std::uint64_t>(order[i]));
      EXPECT_EQ(map.add(part), i == 2);
      if (i == 2) break;
      EXPECT_FALSE(map.add(part));
      EXPECT_EQ(map.point_count(), 0u);
      EXPECT_THAT(map.incomplete(), ElementsAre(4));
    }
    EXPECT_TRUE(map.incomplete().empty());
    const ColouredCloud& cloud = map.keyframes().at(4).cloud;
    ASSERT_EQ(cloud.size(), 150u);
    ASSERT_EQ(cloud.normals.size(), 150u);
    for (std::size_t part = 0; part < 3; ++part)
      EXPECT_EQ(cloud.points[50 * part], random_cloud(10 + part, 50, true).points[0])
          << "in the tiles' order";
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(DenseMap, AnotherVersionOfAKeyframeReplacesItWhenItIsWhole) {
  DenseMap map;
  map.add(tile(1, 0, 1, 1));
  KeyframeTile newer = tile(1, 0, 2, 2);
  newer.part.utime = 77;
  EXPECT_FALSE(map.add(newer));
  EXPECT_EQ(map.point_count(), 50u);
  EXPECT_THAT(map.incomplete(), ElementsAre(1));
  newer.tile = 1;
  EXPECT_TRUE(map.add(newer));
  EXPECT_EQ(map.point_count(), 100u);
  EXPECT_EQ(map.keyframes().at(1).utime, 77);

  newer.tile = 0;
  EXPECT_FALSE(map.add(newer));
  EXPECT_TRUE(map.incomplete().empty()) << "a tile of what is here already is not missed";
}

// A cloud that has changed is published again, of the same utime and in as many tiles; some are lost.
TEST(DenseMap, TilesOfTwoTellingsDoNotMix) {
  const auto published = [](std::int64_t revision, int index) {
    KeyframeTile part = tile(1, index, 3, static_cast<std::uint64_t>(10 * revision + index));
    part.part.revision = revision;
    return part;
  };
  DenseMap map;
  EXPECT_FALSE(map.add(published(1, 0)));
  EXPECT_FALSE(map.add(published(1, 2)));  // 1 is lost
  EXPECT_FALSE(map.add(published(2, 1))) << "of another cloud";
  EXPECT_FALSE(map.add(published(2, 0)));
  EXPECT_TRUE(map.add(published(2, 2)));
  const auto has = [&](std::int64_t revision) {
    const ColouredCloud& cloud = map.keyframes().at(1).cloud;
    ASSERT_EQ(cloud.size(), 150U);
    EXPECT_EQ(map.keyframes().at(1).revision, revision);
    for (int i = 0; i < 3; ++i)
      EXPECT_EQ(cloud.points[static_cast<std::size_t>(50 * i)], published(revision, i).part.cloud.points[0]);
  };
  has(2);
  for (const int index : {0, 1}) EXPECT_FALSE(map.add(published(3, index)));
  has(2);
  EXPECT_THAT(map.incomplete(), ElementsAre(1)) << "what is here is older than what was published";
  for (const int index : {2, 1, 0}) EXPECT_EQ(map.add(published(4, index)), index == 0);
  has(4);
  EXPECT_TRUE(map.incomplete().empty());
}

TEST(DenseMap, FollowsAWholeGraph) {
  Random random(6);
  DenseMap map;
  for (const std::int32_t id : {1, 2, 3, 4}) map.add(tile(id, 0, 1, static_cast<std::uint64_t>(id)));
  const Eigen::Isometry3d first = random_pose(random), third = random_pose(random);
  KeyframeTile broken = tile(5, 0, 1, 5);
  broken.part.T_world_camera.translation().x() = std::nan("");
  EXPECT_THROW(map.follow({{5, broken.part.T_world_camera}}), std::invalid_argument);
  EXPECT_EQ(map.keyframes().size(), 4U);
  map.follow({{1, first}, {3, third}, {7, first}});
  ASSERT_EQ(map.keyframes().size(), 2U);
  EXPECT_TRUE(map.keyframes().at(1).T_world_camera.isApprox(first));
  EXPECT_TRUE(map.keyframes().at(3).T_world_camera.isApprox(third));
}

TEST(DenseMap, CorrectedPosesBendTheMap) {
  Random random(3);
  DenseMap map;
  for (const std::int32_t id : {1, 2}) map.add(tile(id, 0, 1, static_cast<std::uint64_t>(id)));
  const Eigen::Isometry3d first = random_pose(random), second = random_pose(random);
  const std::int64_t before = map.revision();
  EXPECT_THAT(map.correct({{1, first}, {2, second}, {5, first}}), ElementsAre(5));
  EXPECT_GT(map.revision(), before);
  const ColouredCloud all = map.merge_all();
  ASSERT_EQ(all.size(), 100u);
  for (std::size_t i = 0; i < 100; ++i) {
    const Eigen::Isometry3d& T_world_camera = i < 50 ? first : second;
    const ColouredCloud cloud = random_cloud(i < 50 ? 1 : 2, 50, true);
    const Eigen::Vector3d point = T_world_camera * cloud.points[i % 50].cast<double>();
    const Eigen::Vector3d normal = T_world_camera.linear() * cloud.normals[i % 50].cast<double>();
    EXPECT_LT((all.points[i].cast<double>() - point).norm(), 1e-6);
    EXPECT_LT((all.normals[i].cast<double>() - normal).norm(), 1e-6);
    EXPECT_EQ(all.colours[i], cloud.colours[i % 50]);
  }
}

TEST(DenseMap, ACorrectionBetweenTilesCounts) {
  Random random(4);
  DenseMap map;
  map.add(tile(1, 0, 2, 1));
  const Eigen::Isometry3d pose = random_pose(random);
  EXPECT_TRUE(map.correct({{1, pose}}).empty());
  KeyframeTile last = tile(1, 1, 2, 2);
  last.part.T_world_camera = pose;
  map.add(last);
  EXPECT_TRUE(map.keyframes().at(1).T_world_camera.isApprox(pose));
}

TEST(DenseMap, KeyframesWithAndWithoutNormalsMix) {
  DenseMap map;
  map.add(tile(1, 0, 1, 1, false));
  map.add(tile(2, 0, 1, 2, true));
  const ColouredCloud all = map.merge_all();
  ASSERT_EQ(all.normals.size(), 100u);
  EXPECT_FALSE(all.normals[0].allFinite());
  EXPECT_TRUE(all.normals[50].allFinite());
  EXPECT_EQ(map.merge(0.1).normals.size(), map.merge(0.1).size());
}

TEST(DenseMap, CountsPointsAndBytes) {
  DenseMap map;
  EXPECT_EQ(map.memory_bytes(), 0u);
  map.add(tile(1, 0, 1, 1));
  map.add(tile(2, 0, 2, 2));
  EXPECT_EQ(map.point_count(), 50u);
  EXPECT_GE(map.memory_bytes(), 100u * (12 + 12 + 3));
  EXPECT_LT(map.memory_bytes(), 300u * (12 + 12 + 3));
  map.remove(1);
  EXPECT_EQ(map.point_count(), 0u);
  map.clear();
  EXPECT_EQ(map.memory_bytes(), 0u);
  EXPECT_EQ(map.merge(0.1).size(), 0u);
}

TEST(DenseMap, MessagesMakeNoMoreThanTheLimits) {
  DenseMap map({3, 170, 2});
  for (std::int32_t id = 0; id < 3; ++id) EXPECT_TRUE(map.add(tile(id, 0, 1, 1)));
  EXPECT_THROW(map.add(tile(3, 0, 1, 1)), std::invalid_argument) << "a fourth keyframe";
  EXPECT_TRUE(map.add(tile(2, 0, 1, 7))) << "one that is known is replaced";
  EXPECT_FALSE(map.add(tile(2, 0, 2, 7)));
  EXPECT_THROW(map.add(tile(2, 1, 2, 7)), std::invalid_argument) << "200 points";
  EXPECT_EQ(map.point_count(), 150U);
  map.remove(0);
  EXPECT_EQ(map.point_count(), 100U);
  EXPECT_TRUE(map.add(tile(2, 1, 2, 7)));
  EXPECT_EQ(map.point_count(), 150U);
}

TEST(DenseMap, OldestIncompleteKeyframeGoesWhenTooManyWait) {
  DenseMap map({100, 100000, 2});
  for (std::int32_t id = 0; id < 5; ++id) EXPECT_FALSE(map.add(tile(id, 0, 2, 1)));
  EXPECT_THAT(map.incomplete(), ElementsAre(3, 4));
  EXPECT_EQ(map.given_up(), 3);
  EXPECT_TRUE(map.add(tile(3, 1, 2, 1)));
}

TEST(DenseMap, DamagedTilesAreRefused) {
  DenseMap map;
  KeyframeTile bad = tile(1, 3, 3, 1);
  EXPECT_THROW(map.add(bad), std::invalid_argument);
  bad = tile(1, 0, 0, 1);
  EXPECT_THROW(map.add(bad), std::invalid_argument);
  bad = tile(1, 0, 1, 1);
  bad.part.cloud.colours.pop_back();
  EXPECT_THROW(map.add(bad), std::invalid_argument);
  bad = tile(1, 0, 1, 1);
  bad.part.cloud.normals.pop_back();
  EXPECT_THROW(map.add(bad), std::invalid_argument);
  bad = tile(1, 0, 1, 1);
  bad.part.T_world_camera.translation().x() = std::nan("");
  EXPECT_THROW(map.add(bad), std::invalid_argument);
  EXPECT_THROW(map.correct({{1, bad.part.T_world_camera}}), std::invalid_argument);
  EXPECT_TRUE(map.keyframes().empty());
  EXPECT_TRUE(map.incomplete().empty());
}

}  // namespace
}  // namespace lcmslam
