// What a depth image sees through, and what the map makes of it; thin things, edges and noise stay. The whole
// mapper: moving_box_test.cpp.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include <lcmslam/dense_mapper/free_space.hpp>
#include <lcmslam/dense_mapper/voxel_map.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

/// What a camera at the origin sees of surfaces z(u, v), u, v in [-0.5, 0.5] at 0.01.
template <class Depth>
Cloud depth_image(const Depth& depth, float sigma = 0.005f) {
  Cloud cloud;
  for (int row = -50; row <= 50; ++row)
    for (int column = -50; column <= 50; ++column) {
      const float u = 0.01f * static_cast<float>(column), v = 0.01f * static_cast<float>(row);
      const float z = depth(u, v);
      if (z > 0) cloud.points.emplace_back(z * Eigen::Vector3f(u, v, 1)), cloud.sigmas.push_back(sigma);
    }
  return cloud;
}

const Eigen::Vector3f ahead(0, 0, -1);

TEST(FreeSpaceView, SeesThroughWhatIsClearlyBeforeTheMeasured) {
  const FreeSpaceView view(depth_image([](float, float) { return 3.0f; }), {});
  EXPECT_EQ(view.judge({0, 0, 2.9f}, ahead), Visibility::seen_through);
  EXPECT_EQ(view.judge({0, 0, 2.96f}, ahead), Visibility::supported);  // 5 cm and four sigmas
  EXPECT_EQ(view.judge({0, 0, 3.04f}, ahead), Visibility::supported);
  EXPECT_EQ(view.judge({0, 0, 3.5f}, ahead), Visibility::hidden);
  EXPECT_EQ(view.judge({3, 0, 2}, ahead), Visibility::unknown);  // beside the image
  EXPECT_EQ(view.judge({0, 0, -2}, ahead), Visibility::unknown);
  // A slanting surface may err more along the ray.
  EXPECT_EQ(view.judge({0, 0, 2.9f}, Eigen::Vector3f(1, 0, -0.5f).normalized()), Visibility::supported);
}

TEST(FreeSpaceView, NoiseCounts) {
  const FreeSpaceView view(depth_image([](float, float) { return 3.0f; }, 0.05f), {});
  EXPECT_EQ(view.judge({0, 0, 2.8f}, ahead), Visibility::supported);
  EXPECT_EQ(view.judge({0, 0, 2.7f}, ahead), Visibility::seen_through);
}

TEST(FreeSpaceView, HolesTellNothing) {
  const FreeSpaceView view(depth_image([](float u, float) { return std::abs(u) < 0.1f ? 0.0f : 3.0f; }), {});
  EXPECT_EQ(view.judge({0, 0, 2}, ahead), Visibility::unknown);
  EXPECT_EQ(view.judge({0.17f, 0, 2}, ahead), Visibility::unknown);  // at the hole's edge
  EXPECT_EQ(view.judge({0.6f, 0, 2}, ahead), Visibility::seen_through);
  const FreeSpaceView nothing(Cloud(), {});
  EXPECT_EQ(nothing.judge({0, 0, 2}, ahead), Visibility::unknown);
}

// Damaged points, and the last ones that a float holds.
TEST(FreeSpaceView, PointsFarOutDisturbNothing) {
  const Cloud wall = depth_image([](float, float) { return 3.0f; });
  Cloud more = wall;
  const float largest = std::numeric_limits<float>::max(), nan = std::numeric_limits<float>::quiet_NaN();
  for (const Eigen::Vector3f& p :
       {Eigen::Vector3f(1e30f, 0, 0.1f), Eigen::Vector3f(-1e30f, 1e30f, 1), Eigen::Vector3f(largest, 0, 0.1f),
        Eigen::Vector3f(-largest, -largest, 0.5f), Eigen::Vector3f(30, 0, 1), Eigen::Vector3f(0, -30, 1),
        Eigen::Vector3f(nan, 0, 3), Eigen::Vector3f(0, nan, 3), Eigen::Vector3f(0, 0, nan),
        Eigen::Vector3f(0, 0, std::numeric_limits<float>::infinity())}) {
    more.points.push_back(p);
    more.sigmas.push_back(0.005f);
  }
  const FreeSpaceView plain(wall, {}), view(more, {});
  ASSERT_EQ(view.columns(), plain.columns());
  ASSERT_EQ(view.rows(), plain.rows());
  for (float x = -1.4f; x < 1.5f; x += 0.1f)
    for (float z = 2; z < 3.5f; z += 0.09f)
      EXPECT_EQ(view.judge({x, 0.3f, z}, ahead), plain.judge({x, 0.3f, z}, ahead)) << x << " " << z;
  EXPECT_EQ(view.judge({0, 0, 2.9f}, ahead), Visibility::seen_through);
  // Far along a ray: nothing but what it sees through.
  more = wall;
  more.points.emplace_back(0, 0, 1e30f), more.sigmas.push_back(0.005f);
  const FreeSpaceView deep(more, {});
  VoxelMap map;
  EXPECT_TRUE(map.look_through(deep, Eigen::Isometry3d::Identity(), {}, 0).empty());
  EXPECT_EQ(deep.judge({largest, 0, 0.1f}, ahead), Visibility::unknown);
  EXPECT_EQ(deep.judge({0, 0, 2.9f}, ahead), Visibility::seen_through);
}

TEST(FreeSpaceView, ThinThingsAndEdgesStay) {
  // A leg of 2 cm and the edge of a cupboard, 1.5 m away, before a wall: what the map knows of them lies up
  // to 2.5 cm beside them.
  const FreeSpaceView view(
      depth_image([](float u, float) { return std::abs(u) < 0.0067f || u > 0.2f ? 1.5f : 4.0f; }), {});
  for (float x = -0.025f; x <= 0.025f; x += 0.005f) {
    EXPECT_NE(view.judge({x, 0.1f, 1.45f}, ahead), Visibility::seen_through) << x;
    EXPECT_NE(view.judge({0.3f + x, 0.1f, 1.45f}, ahead), Visibility::seen_through) << x;
  }
  EXPECT_EQ(view.judge({0.15f, 0.1f, 1.45f}, ahead), Visibility::seen_through);
}

TEST(FreeSpaceView, AGrazingFloorStays) {
  // 1.2 m below, up to 84 degrees.
  const FreeSpaceView view(depth_image([](float, float v) { return v > 0.1f ? 1.2f / v : 0.0f; }), {});
  int seen_through = 0, supported = 0;
  for (float z = 2.6f; z < 11; z += 0.1f)
    for (const float error : {-0.04f, 0.0f, 0.04f}) {
      const Visibility visibility = view.judge({0, 1.2f + error, z}, {0, -1, 0});
      seen_through += visibility == Visibility::seen_through ? 1 : 0;
      supported += visibility == Visibility::supported ? 1 : 0;
    }
  EXPECT_EQ(seen_through, 0);
  EXPECT_GT(supported, 100);
}

TEST(VoxelMapFreeSpace, WhatHasGoneGoesAndSupportKeeps) {
  Cloud wall, thing;
  add_rectangle(wall, {-2, -2, 3}, {0, 4, 0}, {4, 0, 0}, 0.03);
  add_rectangle(thing, {-0.3, -0.3, 2}, {0, 0.6, 0}, {0.6, 0, 0}, 0.03);
  VoxelMap map;
  for (int i = 0; i < 20; ++i) {
    map.insert(wall, Eigen::Isometry3d::Identity());
    map.insert(thing, Eigen::Isometry3d::Identity());
  }
  const std::size_t before = map.size();
  const FreeSpaceSettings settings;
  const FreeSpaceView empty(depth_image([](float, float) { return 3.0f; }), settings);
  const FreeSpaceView full(
      depth_image([](float u, float v) { return std::max(std::abs(u), std::abs(v)) < 0.15f ? 2.0f : 3.0f; }),
      settings);
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  const int all_rays = settings.rotation * settings.rotation;
  std::int32_t turn = 0;
  for (int i = 0; i < 3 * all_rays; ++i) EXPECT_TRUE(map.look_through(full, here, settings, turn++).empty());
  EXPECT_EQ(map.size(), before);
  TargetPoint found;
  ASSERT_TRUE(map.find({0, 0, 2}, 0.1f, found));
  std::size_t gone = 0;
  for (int i = 0; i < 8 * all_rays; ++i) gone += map.look_through(empty, here, settings, turn++).size();
  EXPECT_EQ(map.size(), before - gone);
  EXPECT_FALSE(map.find({0, 0, 2}, 0.1f, found));
  EXPECT_TRUE(map.find({0, 0, 3}, 0.1f, found));
  EXPECT_EQ(map.cloud().size(), map.size());
  for (const Eigen::Vector3f& p : map.cloud().points) EXPECT_NEAR(p.z(), 3, 0.01);
}

// Seen through once or twice: no partner for now, but there, and found again when a view supports it.
TEST(VoxelMapFreeSpace, WhatWasSeenThroughOnceIsDoubtful) {
  Cloud wall, thing;
  add_rectangle(wall, {-2, -2, 3}, {0, 4, 0}, {4, 0, 0}, 0.03);
  add_rectangle(thing, {-0.3, -0.3, 2}, {0, 0.6, 0}, {0.6, 0, 0}, 0.03);
  VoxelMapSettings map_settings;
  map_settings.dropped_at = -5;
  VoxelMap map(map_settings);
  map.insert(wall, Eigen::Isometry3d::Identity());
  map.insert(thing, Eigen::Isometry3d::Identity());
  FreeSpaceSettings settings;
  settings.rotation = 1;  // every ray in every turn
  auto look = [&, turn = 0](float z) mutable {
    const FreeSpaceView view(
        depth_image([&](float u, float v) { return std::max(std::abs(u), std::abs(v)) < 0.2f ? z : 3.0f; }),
        settings);
    return map.look_through(view, Eigen::Isometry3d::Identity(), settings, turn++).size();
  };
  const std::size_t before = map.size();
  TargetPoint found;
  ASSERT_TRUE(map.find({0, 0, 2}, 0.1f, found));
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(look(3), 0U);
    EXPECT_FALSE(map.find({0, 0, 2}, 0.1f, found)) << "evidence " << -1 - 2 * i;
    EXPECT_TRUE(map.find({0, 0, 3}, 0.1f, found));
    EXPECT_EQ(map.size(), before);
    EXPECT_EQ(map.cloud().size(), before);
    EXPECT_TRUE(map.partners_around({0, 0, 2}, 0.1).points.empty()) << "for the other kinds of targets";
    EXPECT_FALSE(map.partners_around({0, 0, 3}, 0.1).points.empty());
  }
  for (int i = 0; i < 3; ++i) EXPECT_EQ(look(2), 0U);
  EXPECT_TRUE(map.find({0, 0, 2}, 0.1f, found)) << "supported again";
  EXPECT_EQ(map.size(), before);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(look(3), 0U);
  EXPECT_GT(look(3), 50U) << "0, -2, -4, gone";
  EXPECT_LT(map.size(), before);
}

// What moves through a bounded map leaves empty blocks, which are dropped before any place is forgotten.
TEST(VoxelMapFreeSpace, EmptyBlocksGoFirst) {
  Cloud wall, thing, more;
  add_rectangle(wall, {-2, -2, 3.02}, {0, 4, 0}, {4, 0, 0}, 0.03);
  add_rectangle(thing, {-0.9, -0.9, 2.02}, {0, 1.8, 0}, {1.8, 0, 0}, 0.03);
  add_rectangle(more, {-2, -2, -0.5}, {0, 0.6, 0}, {0.6, 0, 0}, 0.03);
  VoxelMap wall_alone;
  wall_alone.insert(wall, Eigen::Isometry3d::Identity());
  VoxelMapSettings map_settings;
  map_settings.miss = 10;
  map_settings.max_blocks = static_cast<int>(wall_alone.blocks()) + 150;  // the thing is more than 100 blocks
  VoxelMap map(map_settings);
  map.insert(wall, Eigen::Isometry3d::Identity());
  map.insert(thing, Eigen::Isometry3d::Identity());
  ASSERT_LE(map.blocks(), static_cast<std::size_t>(map_settings.max_blocks));
  FreeSpaceSettings settings;
  settings.rotation = 1;
  const FreeSpaceView empty(depth_image([](float, float) { return 3.0f; }), settings);
  map.look_through(empty, Eigen::Isometry3d::Identity(), settings, 0);
  const std::size_t left = map.size();
  ASSERT_LT(left, wall_alone.size() + 200);
  map.insert(more, Eigen::Isometry3d(Eigen::Translation3d(-2, -2, -0.5)));
  EXPECT_LT(map.blocks(), wall_alone.blocks() + 50);
  EXPECT_FALSE(map.has_forgotten());
  EXPECT_GT(map.size(), left + 100);
  TargetPoint found;
  EXPECT_TRUE(map.find({1.9f, 1.9f, 3}, 0.1f, found)) << "farthest from there";
}

// Two that are doubtful meet in a deformed map: still doubtful, and not gone before a view takes them.
TEST(VoxelMapFreeSpace, EvidenceStaysInItsRangeWhereSurfelsMerge) {
  VoxelMapSettings map_settings;
  map_settings.miss = 70;
  map_settings.dropped_at = -100;  // the sum of two evidences leaves eight bits
  VoxelMap map(map_settings);
  Cloud thing;
  add_rectangle(thing, {-0.3, -0.3, 2.02}, {0, 0.6, 0}, {0.6, 0, 0}, 0.03);
  const Eigen::Isometry3d aside(Eigen::Translation3d(0, 0, -0.4));
  map.insert(thing, Eigen::Isometry3d::Identity(), 0);
  map.insert(transformed(thing, aside), Eigen::Isometry3d::Identity(), 1);
  FreeSpaceSettings settings;
  settings.rotation = 1;
  const FreeSpaceView empty(depth_image([](float, float) { return 3.0f; }), settings);
  ASSERT_TRUE(map.look_through(empty, Eigen::Isometry3d::Identity(), settings, 0).empty());
  VoxelMap deformed = map.deformed({Eigen::Isometry3d::Identity(), aside.inverse()});
  TargetPoint found;
  EXPECT_GT(deformed.size(), 100U);
  EXPECT_FALSE(deformed.find({0, 0, 2}, 0.1f, found)) << "both were seen through";
  EXPECT_GT(deformed.look_through(empty, Eigen::Isometry3d::Identity(), settings, 1).size(), 100U);
}

}  // namespace
}  // namespace lcmslam
