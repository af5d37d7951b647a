// The targets: each finds what an exhaustive search finds, where it promises to.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

#include <lcmslam/cloud/kd_tree.hpp>
#include <lcmslam/dense_mapper/voxel_map.hpp>
#include <lcmslam/registration/projective_target.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

Eigen::Vector3f random_point(Random& random, double side) {
  const double x = random.uniform(-side, side);
  const double y = random.uniform(-side, side);
  const double z = random.uniform(-side, side);
  return Eigen::Vector3d(x, y, z).cast<float>();
}

// Index of the nearest, ties to the lower one; -1 when farther than max_distance.
int exhaustive(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& query, float max_distance) {
  int best = -1;
  float least = max_distance * max_distance;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float d = (points[i] - query).squaredNorm();
    if (d < least || (d == least && best < 0)) {
      least = d;
      best = static_cast<int>(i);
    }
  }
  return best;
}

TEST(KdTree, FindsTheNearest) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 700; ++i) points.push_back(random_point(random, 1));
    for (int i = 0; i < 50; ++i) points.push_back(points[static_cast<std::size_t>(i)]);  // duplicates
    const KdTree tree(points);
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3f query = random_point(random, 1.3);
      const float max_distance = static_cast<float>(random.uniform(0, 0.5));
      EXPECT_EQ(tree.nearest(query, max_distance).index, exhaustive(points, query, max_distance));
    }
  }
}

TEST(KdTree, FindsTheNearestFewInOrder) {
  Random random(6);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 500; ++i) points.push_back(random_point(random, 1));
  const KdTree tree(points);
  const Eigen::Vector3f query = random_point(random, 1);
  std::vector<float> distances;
  for (const auto& p : points) distances.push_back((p - query).squaredNorm());
  std::sort(distances.begin(), distances.end());
  const auto found = tree.nearest_few(query, 20);
  ASSERT_EQ(found.size(), 20u);
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].squared_distance, distances[i]);
  EXPECT_EQ(tree.nearest_few(query, 1000).size(), points.size());
}

TEST(KdTree, GarbageIsNeverFound) {
  const KdTree empty({});
  EXPECT_EQ(empty.nearest(Eigen::Vector3f::Zero(), 1e9f).index, -1);
  const KdTree tree({Eigen::Vector3f::Constant(nan), Eigen::Vector3f::Ones()});
  EXPECT_EQ(tree.nearest(Eigen::Vector3f::Zero(), 1e9f).index, 1);
  EXPECT_EQ(tree.nearest(Eigen::Vector3f::Constant(nan), 1e9f).index, -1);
  EXPECT_EQ(tree.nearest(Eigen::Vector3f::Zero(), -1).index, -1);
  const KdTree same(std::vector<Eigen::Vector3f>(1000, Eigen::Vector3f::Ones()));
  EXPECT_EQ(same.nearest(Eigen::Vector3f::Zero(), 1e9f).index, 0);
}

TEST(VoxelMap, FindsTheNearestSurfelAtAnyDistance) {
  Random random(7);
  VoxelMapSettings settings;
  settings.voxel_size = 0.1;
  VoxelMap map(settings);
  Cloud cloud;
  for (int i = 0; i < 2000; ++i) {
    cloud.points.push_back(random_point(random, 1));
    cloud.normals.push_back(Eigen::Vector3f::UnitZ());
  }
  map.insert(cloud, Eigen::Vector3d::Zero());
  const Cloud surfels = map.cloud();
  ASSERT_EQ(surfels.size(), map.size());
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3f query = random_point(random, 1.4);
    const float max_distance = static_cast<float>(random.uniform(0, 0.9));
    const int expected = exhaustive(surfels.points, query, max_distance);
    TargetPoint found;
    ASSERT_EQ(map.find(query, max_distance, found), expected >= 0);
    if (expected < 0) continue;
    EXPECT_EQ(found.point, surfels.points[static_cast<std::size_t>(expected)]);
  }
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
    cloud.normals.push_back(Eigen::Vector3f::UnitZ());
    cloud.sigmas.push_back(0.01f);
    map.insert(cloud, Eigen::Vector3d::Zero());
  }
  ASSERT_EQ(map.size(), 1u);
  const Cloud surfels = map.cloud();
  EXPECT_NEAR(surfels.points[0].z(), 0.05, 4 * 0.01 / std::sqrt(frames));
  EXPECT_NEAR(surfels.sigmas[0], 0.01 / std::sqrt(frames), 1e-5);
}

TEST(VoxelMap, BothSidesOfABoardStayApart) {
  VoxelMap map;
  Cloud cloud;
  cloud.points = {{0.02f, 0.02f, 0.01f}, {0.02f, 0.02f, 0.03f}};
  cloud.normals = {-Eigen::Vector3f::UnitZ(), Eigen::Vector3f::UnitZ()};
  map.insert(cloud, Eigen::Vector3d::Zero());
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
    cloud.normals.push_back(Eigen::Vector3f::UnitZ());
    map.insert(cloud, cloud.points.back().cast<double>());
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
  map.insert(cloud, Eigen::Vector3d::Zero());
  EXPECT_EQ(map.size(), 0u);
  TargetPoint found;
  EXPECT_FALSE(map.find({nan, 0, 0}, 1, found));
  EXPECT_FALSE(map.find({1e30f, 0, 0}, 1, found));
  VoxelMapSettings bad;
  bad.voxel_size = 0;
  EXPECT_THROW(VoxelMap{bad}, std::invalid_argument);
}

// What the camera saw in a cell is found from any point on its ray.
TEST(ProjectiveTarget, FindsWhatTheCameraSawThere) {
  ProjectionGrid grid;
  Cloud cloud;
  for (int v = 0; v < grid.height; ++v)
    for (int u = 0; u < grid.width; ++u) {
      const double z = 2 + 0.3 * std::sin(0.05 * u);
      const Eigen::Vector3d p(z * (u - grid.cx) / grid.fx, z * (v - grid.cy) / grid.fy, z);
      cloud.points.push_back(p.cast<float>());
    }
  const Eigen::Isometry3d T_target_camera = se3_exp(twist(1, 2, 3, 0.3, -0.2, 0.1));
  const Cloud in_target = transformed(cloud, T_target_camera);
  const ProjectiveTarget target(in_target, T_target_camera, grid, 0);
  EXPECT_EQ(target.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); i += 97) {
    TargetPoint found;
    const Eigen::Vector3d on_ray = T_target_camera * (1.03 * cloud.points[i].cast<double>());
    ASSERT_TRUE(target.find(on_ray.cast<float>(), 0.2f, found));
    EXPECT_EQ(found.point, in_target.points[i]);
    EXPECT_FALSE(target.find(on_ray.cast<float>(), 0.01f, found));
  }
}

TEST(ProjectiveTarget, TheNearerSurfaceHidesTheFarther) {
  Cloud cloud;
  cloud.points = {{0, 0, 3}, {0, 0, 2}, {0, 0, 4}};
  const ProjectiveTarget target(cloud, Eigen::Isometry3d::Identity());
  TargetPoint found;
  ASSERT_TRUE(target.find({0, 0, 3}, 5, found));
  EXPECT_EQ(found.point.z(), 2);
  EXPECT_FALSE(target.find({0, 0, -3}, 50, found));   // behind
  EXPECT_FALSE(target.find({50, 0, 3}, 500, found));  // beside
}

TEST(VoxelMap, PartnersOfColouredCloudsHaveIntensityAndItsGradient) {
  Cloud cloud = wall(0.02);
  VoxelMap map;
  map.insert(cloud, Eigen::Vector3d::Zero());
  TargetPoint found;
  ASSERT_TRUE(map.find({2, 0.1f, 0.2f}, 0.1f, found));
  EXPECT_TRUE(std::isnan(found.intensity));
  EXPECT_FALSE(map.has_intensities());
  // Brighter to the left and upwards.
  const Eigen::Vector3f gradient(0, 0.2f, 0.1f);
  for (const Eigen::Vector3f& p : cloud.points) cloud.intensities.push_back(0.5f + gradient.dot(p));
  map = VoxelMap();
  for (int i = 0; i < 3; ++i) map.insert(cloud, Eigen::Vector3d::Zero());
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

}  // namespace
}  // namespace lcmslam
