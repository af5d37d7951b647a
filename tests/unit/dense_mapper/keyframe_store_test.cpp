#include <lcmslam/dense_mapper/keyframe_store.hpp>

#include <gtest/gtest.h>

#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

Eigen::Isometry3d at(double x) {
  return planar_pose(x, 0, 0);
}

/// `count` points on a line, 5 cm apart, 1 m ahead of the camera.
ColouredCloud line(std::size_t count, double y = 0) {
  ColouredCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    cloud.points.emplace_back(0.05f * static_cast<float>(i), static_cast<float>(y), 1.0f);
    cloud.normals.emplace_back(0, 0, -1);
    cloud.sigmas.push_back(0.003f);
    cloud.colours.emplace_back(1, 2, 3);
  }
  return cloud;
}

// Two keyframes 0.3 m or 0.3 rad apart see different things; half of it is enough where little is known.
TEST(KeyframeStore, AKeyframeIsDueFarFromEveryOther) {
  KeyframeStore store({});
  EXPECT_TRUE(store.is_due(at(0), 1));
  store.add(0, 10, at(0), line(3));
  store.add(1, 20, at(1), line(3));
  EXPECT_EQ(store.made(), 2);
  EXPECT_FALSE(store.is_due(at(0.29), 1));
  EXPECT_TRUE(store.is_due(at(0.31), 1));
  EXPECT_FALSE(store.is_due(at(0.8), 1));  // the second one is near
  EXPECT_FALSE(store.is_due(at(0.14), 0.4));
  EXPECT_TRUE(store.is_due(at(0.16), 0.4));
  EXPECT_FALSE(store.is_due(planar_pose(0, 0, 0.29), 1));
  EXPECT_TRUE(store.is_due(planar_pose(0, 0, 0.31), 1));
}

TEST(KeyframeStore, WhatIsFarthestIsThinnedFirstUntilATenthIsFree) {
  DenseMapperSettings settings;
  settings.keyframe_voxel = 0.04;
  settings.keyframe_points = 400;
  KeyframeStore store(settings);
  for (int i = 0; i < 4; ++i) store.add(i, i, at(i), line(100));
  for (const auto& keyframe : store.all()) EXPECT_EQ(keyframe.cloud.size(), 100U);
  store.add(4, 4, at(4), line(100));
  std::size_t points = 0;
  for (const auto& keyframe : store.all()) points += keyframe.cloud.size();
  EXPECT_LE(points, 360U);
  EXPECT_GT(points, 250U);
  EXPECT_EQ(store.all().back().cloud.size(), 100U);
  EXPECT_EQ(store.all().back().voxel, 0.04);
  for (std::size_t i = 1; i < 5; ++i) EXPECT_GE(store.all()[i - 1].voxel, store.all()[i].voxel);
  EXPECT_GT(store.all().front().voxel, 0.04);
}

TEST(KeyframeStore, ARetiredCloudJoinsItsNearestSuccessorWhereItWas) {
  KeyframeStore store({});
  for (int i = 0; i < 3; ++i) store.add(i, i, at(i), line(10, 0.1 * i));
  store.add(3, 3, at(1.2), line(10, 0.3));
  // The second node goes; what is its own belongs to the one that becomes the third.
  store.thin({{false, true, false, false}, {0, 2, 1, 2}});
  ASSERT_EQ(store.all().size(), 3U);
  EXPECT_EQ(store.all()[1].node, 1);
  EXPECT_EQ(store.all()[2].node, 2);
  EXPECT_TRUE(store.merging());
  EXPECT_TRUE(store.take_changed(true).empty());
  store.merge_next();
  EXPECT_FALSE(store.merging());
  const auto& successor = store.all()[2];  // 0.2 m away
  ASSERT_EQ(successor.cloud.size(), 20U);
  int found = 0;
  for (const Eigen::Vector3f& p : successor.cloud.points) {
    const Eigen::Vector3d world = successor.T_world_camera * p.cast<double>();
    found += std::abs(world.y() - 0.1) < 1e-6 && world.x() > 0.99 ? 1 : 0;
  }
  EXPECT_EQ(found, 10);
  EXPECT_EQ(store.take_changed(false), std::vector<std::size_t>{2});
  store.merge_next();  // nothing is left
  EXPECT_EQ(store.all()[2].cloud.size(), 20U);
}

TEST(KeyframeStore, OnlyNotableChangesArePublishedBeforeTheEnd) {
  KeyframeStore store({});
  store.add(0, 0, at(0), line(100));
  store.add(1, 1, at(1), line(100));
  std::vector<bool> one(100, false), three(100, false);
  one[5] = three[1] = three[2] = three[3] = true;
  store.swept(0, one);
  store.swept(1, three);
  EXPECT_EQ(store.all()[0].cloud.size(), 99U);
  EXPECT_EQ(store.all()[1].cloud.size(), 97U);
  EXPECT_EQ(store.all()[1].cloud.points[1], line(100).points[4]);
  EXPECT_EQ(store.take_changed(false), std::vector<std::size_t>{1});
  EXPECT_TRUE(store.take_changed(false).empty());
  EXPECT_EQ(store.take_changed(true), std::vector<std::size_t>{0});
  EXPECT_TRUE(store.take_changed(true).empty());
}

// Also those that wait to join others.
TEST(KeyframeStore, KeyframesMoveWithTheirNodesAndLaterOnesWithTheLast) {
  KeyframeStore store({});
  for (int i = 0; i < 3; ++i) store.add(i, i, at(i), line(10));
  store.thin({{false, true, false}, {0, 0, 1}});  // the second one's things belong to the first node
  store.add(2, 3, at(3), line(10));
  const Eigen::Isometry3d up(Eigen::Translation3d(0, 0, 1)), aside(Eigen::Translation3d(0, 2, 0));
  store.deform({up, aside});
  EXPECT_TRUE(store.all()[0].T_world_camera.isApprox(up * at(0)));
  EXPECT_TRUE(store.all()[1].T_world_camera.isApprox(aside * at(2)));
  EXPECT_TRUE(store.all()[2].T_world_camera.isApprox(aside * at(3)));
  store.merge_next();
  const auto& first = store.all()[0];
  ASSERT_EQ(first.cloud.size(), 20U);
  for (const Eigen::Vector3f& p : first.cloud.points)  // all went up together
    EXPECT_NEAR((first.T_world_camera * p.cast<double>()).z(), 2, 1e-6);
}

}  // namespace
}  // namespace lcmslam
