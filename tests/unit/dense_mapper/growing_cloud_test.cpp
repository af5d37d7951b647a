// The thesis's target: exact neighbours in a cloud that grows.

#include <lcmslam/dense_mapper/thesis/growing_cloud.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include <lcmslam/cloud/kd_tree.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

TEST(GrowingCloud, FindsWhatAnExhaustiveSearchFinds) {
  Random random(1);
  GrowingCloud grown(0);
  std::vector<Eigen::Vector3f> all;
  for (int batch = 0; batch < 40; ++batch) {
    Cloud cloud;
    for (int i = 0; i < 5 + 17 * (batch % 7); ++i)
      cloud.points.emplace_back(
          Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)).cast<float>());
    all.insert(all.end(), cloud.points.begin(), cloud.points.end());
    EXPECT_EQ(grown.add(cloud), cloud.size());
    ASSERT_EQ(grown.size(), all.size());
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3f query =
          Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)).cast<float>();
      float best = 0.3f * 0.3f;
      const Eigen::Vector3f* nearest = nullptr;
      for (const auto& p : all)
        if ((p - query).squaredNorm() <= best) best = (p - query).squaredNorm(), nearest = &p;
      TargetPoint found;
      ASSERT_EQ(grown.find(query, 0.3f, found), nearest != nullptr);
      if (nearest) {
        EXPECT_EQ(found.point, *nearest);
      }
    }
  }
}

TEST(GrowingCloud, CountsItsPointsAndTheirTrees) {
  Random random(1);
  Cloud cloud;
  for (int i = 0; i < 1000; ++i)
    cloud.points.emplace_back(
        Eigen::Vector3d(random.normal(), random.normal(), random.normal()).cast<float>());
  GrowingCloud grown(0);
  grown.add(cloud);
  constexpr std::size_t in_cloud = 2 * sizeof(Eigen::Vector3f) + sizeof(float);  // point, normal, sigma
  EXPECT_GT(grown.memory_bytes(), cloud.size() * in_cloud + KdTree(cloud.points).memory_bytes() - 1);
  EXPECT_LT(grown.memory_bytes(), 3 * cloud.size() * in_cloud);
}

TEST(GrowingCloud, NearPointsAreOne) {
  GrowingCloud grown(0.02);
  Cloud cloud;
  cloud.points = {{0, 0, 0}, {0.001f, 0, 0}, {1, 0, 0}};
  EXPECT_EQ(grown.add(cloud), 3U);  // a cloud's own points are not compared
  cloud.points = {{0.015f, 0, 0}, {0.03f, 0, 0}, Eigen::Vector3f::Constant(NAN)};
  EXPECT_EQ(grown.add(cloud), 1U);
  EXPECT_EQ(grown.size(), 4U);
  TargetPoint found;
  ASSERT_TRUE(grown.find({0.03f, 0, 0}, 0.001f, found));
  EXPECT_FALSE(found.normal.allFinite());
  EXPECT_THROW(GrowingCloud(-1), std::invalid_argument);
  EXPECT_THROW(GrowingCloud{NAN}, std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
