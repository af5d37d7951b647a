#include <lcmslam/dense_mapper/voxel_map.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <limits>

#include <lcmslam/registration/registration.hpp>
#include "tests/support/cloud_scenes.hpp"
#include "tests/support/exhaustive_search.hpp"

namespace lcmslam {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

TEST(VoxelMap, FindsTheNearestSurfelAtAnyDistance) {
  Random random(7);
  VoxelMapSettings settings;
  settings.voxel_size = 0.1;
  VoxelMap map(settings);
  Cloud cloud;
  for (int i = 0; i < 2000; ++i) {
    cloud.points.push_back(random_point_within(random, 1));
    cloud.normals.emplace_back(Eigen::Vector3f::UnitZ());
  }
  map.insert(cloud, Eigen::Isometry3d::Identity());
  const Cloud surfels = map.cloud();
  ASSERT_EQ(surfels.size(), map.size());
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3f query = random_point_within(random, 1.4);
    const float max_distance = static_cast<float>(random.uniform(0, 0.9));
    const int expected = nearest_by_exhaustion(surfels.points, query, max_distance);
    TargetPoint found;
    ASSERT_EQ(map.find(query, max_distance, found), expected >= 0);
    if (expected < 0) continue;
    EXPECT_EQ(found.point, surfels.points[static_cast<std::size_t>(expected)]);
  }
}

TEST(VoxelMap, TellsWhoseSurfelsACloudLiesOn) {
  VoxelMap map;
  Cloud first, second, asked;
  for (int i = 0; i < 100; ++i) {
    const auto x = 0.05f * static_cast<float>(i) + 0.01f;
    for (Cloud* cloud : {&first, &second, &asked}) cloud->normals.emplace_back(Eigen::Vector3f::UnitZ());
    first.points.emplace_back(x, 0.f, 0.f);
    second.points.emplace_back(x, 1.f, 0.f);
    asked.points.emplace_back(x, i < 60 ? 0.02f : i < 80 ? 1.02f : 2.f, 0.01f);  // the last twenty on nothing
  }
  map.insert(first, Eigen::Isometry3d::Identity(), 2);
  map.insert(second, Eigen::Isometry3d::Identity(), 5);
  map.insert(first, Eigen::Isometry3d::Identity(), 7);  // seen again: it stays the first one's
  EXPECT_EQ(map.owners(asked, 1000), (std::vector<int>{0, 0, 60, 0, 0, 20}));
  const std::vector<int> of_some = map.owners(asked, 50);
  ASSERT_EQ(of_some.size(), 6U);
  EXPECT_NEAR(of_some[2], 20, 2) << "of every third";
  for (Eigen::Vector3f& normal : asked.normals) normal = -normal;
  EXPECT_TRUE(map.owners(asked, 1000).empty()) << "the other side of it";
  EXPECT_TRUE(map.owners(Cloud(), 1000).empty());
}

TEST(VoxelMap, TellsHowFarOtherSurfelsAreAtLeast) {
  Random random(17);
  VoxelMapSettings settings;
  settings.voxel_size = 0.1;
  VoxelMap map(settings);
  Cloud cloud;
  for (int i = 0; i < 2000; ++i) {
    cloud.points.push_back(random_point_within(random, 1));
    cloud.normals.emplace_back(Eigen::Vector3f::UnitZ());
  }
  map.insert(cloud, Eigen::Isometry3d::Identity());
  const std::vector<Eigen::Vector3f> surfels = map.cloud().points;
  int useful = 0;
  for (int i = 0; i < 4000; ++i) {
    // Anywhere, or where eight blocks of 0.4 m meet.
    Eigen::Vector3f query = random_point_within(random, 1.4);
    if (i % 2 == 0) query = (2.5f * query).array().round() / 2.5f + random_point_within(random, 0.06).array();
    const float max_distance = static_cast<float>(random.uniform(0, 0.3));
    TargetPoint found;
    float others = 0;
    const bool is_found = map.find_nearest(query, max_distance, found, others);
    float next = 1e9f;
    for (const Eigen::Vector3f& p : surfels)
      if (!is_found || p != found.point) next = std::min(next, (p - query).norm());
    EXPECT_LE(others, 1.0001f * next);
    const float distance = is_found ? (found.point - query).norm() : max_distance;
    useful += others > distance + 0.01f ? 1 : 0;
  }
  EXPECT_GT(useful, 1500);
}

TEST(VoxelMap, WhatStaysTheNearestIsNotLookedForAgain) {
  /// The same surfels, without a word on how far others are.
  struct Silent : Target {
    const VoxelMap& map;
    mutable int searches = 0;
    bool tells;
    Silent(const VoxelMap& m, bool t) : map(m), tells(t) {}
    bool find(const Eigen::Vector3f& p, float most, TargetPoint& found) const override {
      ++searches;
      return map.find(p, most, found);
    }
    bool find_nearest(const Eigen::Vector3f& p, float most, TargetPoint& found,
                      float& others) const override {
      if (!tells) return Target::find_nearest(p, most, found, others);
      ++searches;
      return map.find_nearest(p, most, found, others);
    }
    bool finds_nearest() const override { return true; }
    std::size_t size() const override { return map.size(); }
  };
  VoxelMap map;
  map.insert(room(0.01), Eigen::Isometry3d::Identity());
  Cloud source = transformed(room(0.023), se3_exp(twist(0.02, -0.03, 0.01, 0.02, 0.01, -0.03)));
  Random random(5);
  for (Eigen::Vector3f& p : source.points)
    for (int axis = 0; axis < 3; ++axis) p[axis] += static_cast<float>(random.normal(0, 0.004));
  RegistrationSettings settings;
  settings.max_distance = 0.1;
  settings.epsilon_translation = settings.epsilon_rotation = 1e-7;
  const Silent silent(map, false), telling(map, true);
  const auto expected = register_cloud(source, silent, Eigen::Isometry3d::Identity(), settings);
  const auto result = register_cloud(source, telling, Eigen::Isometry3d::Identity(), settings);
  ASSERT_GT(expected.rms.size(), 5u);
  EXPECT_EQ(result.T_target_source.matrix(), expected.T_target_source.matrix());
  EXPECT_EQ(result.rms, expected.rms);
  EXPECT_LT(2 * telling.searches, silent.searches);
}

TEST(VoxelMap, AveragesWhatIsSeenOften) {
  VoxelMapSettings settings;
  settings.voxel_size = 0.1;
  VoxelMap map(settings);
  Random random(8);
  const int frames = 50;
  for (int i = 0; i < frames; ++i) {
    Cloud cloud;
    cloud.points.emplace_back(0.05f, 0.05f, static_cast<float>(random.normal(0.05, 0.01)));
    cloud.normals.emplace_back(Eigen::Vector3f::UnitZ());
    cloud.sigmas.push_back(0.01f);
    map.insert(cloud, Eigen::Isometry3d::Identity());
  }
  ASSERT_EQ(map.size(), 1u);
  const Cloud surfels = map.cloud();
  EXPECT_NEAR(surfels.points[0].z(), 0.05, 4 * 0.01 / std::sqrt(frames));
  EXPECT_NEAR(surfels.sigmas[0], 0.01 / std::sqrt(frames), 1e-5);
}

// A running mean goes on scattering, however long it has seen the same.
TEST(VoxelMap, IsNoSurerThanWhatItRemembers) {
  VoxelMapSettings settings;
  settings.voxel_size = 0.1;
  settings.max_weight = 10;
  VoxelMap map(settings);
  Random random(9);
  double squares = 0;  // of errors over sigmas
  for (int i = 0; i < 20'000; ++i) {
    Cloud cloud;
    cloud.points.emplace_back(0.05f, 0.05f, static_cast<float>(random.normal(0.05, 0.005)));
    cloud.normals.emplace_back(Eigen::Vector3f::UnitZ());
    cloud.sigmas.push_back(0.005f);
    map.insert(cloud, Eigen::Isometry3d::Identity());
    if (i < 100) continue;
    TargetPoint found;
    ASSERT_TRUE(map.find({0.05f, 0.05f, 0.05f}, 0.1f, found));
    EXPECT_EQ(found.sigma, map.cloud().sigmas[0]);
    const double error = (found.point.z() - 0.05) / found.sigma;
    squares += error * error;
  }
  EXPECT_NEAR(squares / 19'900, 1, 0.15);
}

// A stray point counts for as long as it takes to see it again, and then no more.
TEST(VoxelMap, WhatWasSeenOnceIsFoundForAWhile) {
  VoxelMapSettings settings;
  settings.min_observations = 3;
  VoxelMap map(settings);
  const auto insert = [&](const std::vector<float>& heights) {
    Cloud cloud;
    for (const float z : heights) {
      cloud.points.emplace_back(0.05f, 0.05f, z);
      cloud.normals.emplace_back(Eigen::Vector3f::UnitZ());
      cloud.sigmas.push_back(0.01f);
    }
    map.insert(cloud, Eigen::Isometry3d::Identity());
  };
  TargetPoint found;
  const auto finds = [&](float z) { return map.find({0.05f, 0.05f, z}, 0.02f, found); };
  insert({0.05f, 1.05f});
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(finds(0.05f) && finds(1.05f)) << i;
    insert({0.05f});
  }
  EXPECT_TRUE(finds(1.05f)) << "of the last three";
  insert({0.05f});
  EXPECT_TRUE(finds(0.05f));
  EXPECT_FALSE(finds(1.05f));
  EXPECT_FALSE(map.deformed({Eigen::Isometry3d::Identity()}).find({0.05f, 0.05f, 1.05f}, 0.02f, found));
}

TEST(VoxelMap, AnOldSurfaceThatMovedIsFollowed) {
  VoxelMapSettings settings;
  settings.voxel_size = 0.1;
  settings.max_weight = 10;
  VoxelMap map(settings);
  const auto insert = [&](float z, int frames) {
    Cloud cloud;
    cloud.points.emplace_back(0.05f, 0.05f, z);
    cloud.normals.emplace_back(Eigen::Vector3f::UnitZ());
    cloud.sigmas.push_back(0.01f);
    for (int i = 0; i < frames; ++i) map.insert(cloud, Eigen::Isometry3d::Identity());
  };
  insert(0.04f, 100);
  insert(0.08f, 30);
  EXPECT_NEAR(map.cloud().points[0].z(), 0.08, 0.004);
}

// A view that moves passes what stands, and not what goes with it.
TEST(VoxelMap, WhatIsNotPassedStaysYoung) {
  Cloud cloud;
  cloud.points.emplace_back(0.05f, 0.05f, 0.05f);
  cloud.normals.emplace_back(Eigen::Vector3f::UnitZ());
  TargetPoint found;
  const auto is_young_after = [&](double moved, double turned) {
    VoxelMap map;
    for (int i = 0; i < 10; ++i)
      map.insert(cloud, i < 9 ? Eigen::Isometry3d::Identity() : planar_pose(moved, 0, turned));
    EXPECT_TRUE(map.find(cloud.points[0], 0.1f, found));
    const bool young = found.young;
    const VoxelMap moved_map = map.deformed({planar_pose(1, 2, 0.5)});
    EXPECT_TRUE(
        moved_map.find((planar_pose(1, 2, 0.5) * cloud.points[0].cast<double>()).cast<float>(), 0.1f, found));
    EXPECT_EQ(found.young, young);
    return young;
  };
  EXPECT_TRUE(is_young_after(0, 0));
  EXPECT_TRUE(is_young_after(0.06, 0));
  EXPECT_FALSE(is_young_after(0.13, 0));
  EXPECT_FALSE(is_young_after(-0.13, 0));
  cloud.points[0] = {2, 0, 0.05f};
  EXPECT_TRUE(is_young_after(0, 0.02));
  EXPECT_FALSE(is_young_after(0, 0.08));
}

TEST(VoxelMap, BothSidesOfABoardStayApart) {
  VoxelMap map;
  Cloud cloud;
  cloud.points = {{0.02f, 0.02f, 0.01f}, {0.02f, 0.02f, 0.03f}};
  cloud.normals = {-Eigen::Vector3f::UnitZ(), Eigen::Vector3f::UnitZ()};
  map.insert(cloud, Eigen::Isometry3d::Identity());
  EXPECT_EQ(map.size(), 2u);
}

TEST(VoxelMap, StaysWithinItsBoundAndForgetsTheFarthest) {
  VoxelMapSettings settings;
  settings.voxel_size = 0.1;
  settings.max_blocks = 100;
  VoxelMap map(settings);
  for (int i = 0; i < 1000; ++i) {
    Cloud cloud;
    cloud.points.emplace_back(0.4f * static_cast<float>(i) + 0.2f, 0.2f, 0.2f);
    cloud.normals.emplace_back(Eigen::Vector3f::UnitZ());
    map.insert(cloud, Eigen::Isometry3d(Eigen::Translation3d(cloud.points.back().cast<double>())));
    ASSERT_LE(map.blocks(), 100u);
  }
  TargetPoint found;
  EXPECT_TRUE(map.find({399.8f, 0.2f, 0.2f}, 0.01f, found));
  EXPECT_TRUE(map.find({390.2f, 0.2f, 0.2f}, 0.21f, found));
  EXPECT_FALSE(map.find({0.2f, 0.2f, 0.2f}, 0.01f, found));
}

TEST(VoxelMap, GarbageIsLeftOut) {
  VoxelMap map;
  Cloud cloud;
  cloud.points = {{nan, 0, 0}, {1e30f, 0, 0}, {0, 0, 0}};
  cloud.normals = {Eigen::Vector3f::UnitZ(), Eigen::Vector3f::UnitZ(), Eigen::Vector3f::Constant(nan)};
  map.insert(cloud, Eigen::Isometry3d::Identity());
  EXPECT_EQ(map.size(), 0u);
  TargetPoint found;
  EXPECT_FALSE(map.find({nan, 0, 0}, 1, found));
  EXPECT_FALSE(map.find({1e30f, 0, 0}, 1, found));
  VoxelMapSettings bad;
  bad.voxel_size = 0;
  EXPECT_THROW(VoxelMap{bad}, std::invalid_argument);
}

TEST(VoxelMap, PartnersOfColouredCloudsHaveIntensityAndItsGradient) {
  Cloud cloud = wall(0.02);
  VoxelMap map;
  map.insert(cloud, Eigen::Isometry3d::Identity());
  TargetPoint found;
  ASSERT_TRUE(map.find({2, 0.1f, 0.2f}, 0.1f, found));
  EXPECT_TRUE(std::isnan(found.intensity));
  EXPECT_FALSE(map.has_intensities());
  // Brighter to the left and upwards.
  const Eigen::Vector3f gradient(0, 0.2f, 0.1f);
  for (const Eigen::Vector3f& p : cloud.points) cloud.intensities.push_back(0.5f + gradient.dot(p));
  map = VoxelMap();
  for (int i = 0; i < 3; ++i) map.insert(cloud, Eigen::Isometry3d::Identity());
  EXPECT_TRUE(map.has_intensities());
  EXPECT_EQ(map.cloud().intensities.size(), map.size());
  const VoxelMap deformed = map.deformed({Eigen::Isometry3d::Identity()});
  for (const VoxelMap* each : std::initializer_list<const VoxelMap*>{&map, &deformed}) {
    for (float y = -1; y < 1; y += 0.13f) {
      ASSERT_TRUE(each->find({2, y, 0.2f}, 0.1f, found));
      EXPECT_NEAR(found.intensity, 0.5f + gradient.dot(found.point), 1e-3f);
      EXPECT_LT((found.gradient - gradient).norm(), 5e-3f) << y;
    }
  }
}

TEST(VoxelMap, BendsWithItsKeyframes) {
  Cloud first, second_cloud;
  add_rectangle(first, {1.01, 0.013, 0.017}, {0, 1, 0}, {0, 0, 1});
  add_rectangle(second_cloud, {3.01, 0.013, 0.017}, {0, 1, 0}, {0, 0, 1});
  VoxelMap map;
  map.insert(first, Eigen::Isometry3d::Identity(), 0);
  map.insert(second_cloud, Eigen::Isometry3d::Identity(), 5);
  const Eigen::Isometry3d moved(Eigen::Translation3d(0, 0, 2));
  const VoxelMap deformed = map.deformed({Eigen::Isometry3d::Identity(), moved});  // 5 goes with the last
  EXPECT_EQ(deformed.size(), map.size());
  EXPECT_NE(deformed.revision(), map.revision());
  TargetPoint found;
  EXPECT_TRUE(deformed.find({1, 0.5f, 0.5f}, 0.05f, found));
  EXPECT_FALSE(deformed.find({3, 0.5f, 0.5f}, 0.05f, found));
  ASSERT_TRUE(deformed.find({3, 0.5f, 2.5f}, 0.05f, found));
  EXPECT_NEAR(std::abs(found.normal.x()), 1, 1e-5);
  // What turns with its keyframe shows another side.
  const Eigen::Isometry3d turned(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  ASSERT_TRUE(map.deformed({turned, moved}).find({-0.5f, 1, 0.5f}, 0.05f, found));
  EXPECT_NEAR(std::abs(found.normal.y()), 1, 1e-5);
  // A copy that comes to lie on the original becomes one with it.
  VoxelMap twice;
  twice.insert(first, Eigen::Isometry3d::Identity(), 0);
  twice.insert(transformed(first, moved), Eigen::Isometry3d::Identity(), 1);
  EXPECT_EQ(twice.deformed({Eigen::Isometry3d::Identity(), moved.inverse()}).size(), map.size() / 2);
}

// Blocks that are out of reach are left out, none of which a corner reaches in.
TEST(VoxelMap, PartnersAroundAreAllThatAreNear) {
  VoxelMap map;
  map.insert(room(0.03), Eigen::Isometry3d::Identity());
  const Cloud all = map.cloud();
  Random random(7);
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector3d centre(random.uniform(0, 4), random.uniform(-2, 2), random.uniform(-1.5, 1.5));
    const double radius = random.uniform(0.02, 2);
    std::vector<Eigen::Vector3f> near;
    for (const Eigen::Vector3f& p : all.points)
      if ((p - centre.cast<float>()).squaredNorm() <= static_cast<float>(radius * radius)) near.push_back(p);
    EXPECT_EQ(map.partners_around(centre, radius).points, near) << i;
  }
}

}  // namespace
}  // namespace lcmslam
