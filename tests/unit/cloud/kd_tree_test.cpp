#include <lcmslam/cloud/kd_tree.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tests/support/exhaustive_search.hpp"

namespace lcmslam {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

TEST(KdTree, FindsTheNearest) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 700; ++i) points.push_back(random_point_within(random, 1));
    for (int i = 0; i < 50; ++i) points.push_back(points[static_cast<std::size_t>(i)]);  // duplicates
    const KdTree tree(points);
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3f query = random_point_within(random, 1.3);
      const float max_distance = static_cast<float>(random.uniform(0, 0.5));
      EXPECT_EQ(tree.nearest(query, max_distance).index, nearest_by_exhaustion(points, query, max_distance));
    }
    const std::size_t least = points.size() * (sizeof(Eigen::Vector3f) + sizeof(std::int32_t));
    EXPECT_GT(tree.memory_bytes(), least);
    EXPECT_LT(tree.memory_bytes(), 5 * least);
  }
}

TEST(KdTree, FindsTheNearestFewInOrder) {
  Random random(6);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 500; ++i) points.push_back(random_point_within(random, 1));
  const KdTree tree(points);
  const Eigen::Vector3f query = random_point_within(random, 1);
  std::vector<float> distances;
  for (const auto& p : points) distances.push_back((p - query).squaredNorm());
  std::sort(distances.begin(), distances.end());
  const auto found = tree.nearest_few(query, 20);
  ASSERT_EQ(found.size(), 20u);
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].squared_distance, distances[i]);
  EXPECT_EQ(tree.nearest_few(query, 1000).size(), points.size());
}

// From the middle of a cell of a regular grid its eight corners are equally far.
TEST(KdTree, TiesGoToTheLowerIndex) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 512; ++i) {
    const int shuffled = (i * 197) % 512;
    points.emplace_back(static_cast<float>(shuffled % 8), static_cast<float>(shuffled / 8 % 8),
                        static_cast<float>(shuffled / 64));
  }
  const KdTree tree(points);
  for (int cell = 0; cell < 343; ++cell) {
    const Eigen::Vector3f query(static_cast<float>(cell % 7) + 0.5f, static_cast<float>(cell / 7 % 7) + 0.5f,
                                static_cast<float>(cell / 49) + 0.5f);
    EXPECT_EQ(tree.nearest(query, 10).index, nearest_by_exhaustion(points, query, 10));
    std::vector<std::int32_t> corners;
    for (std::size_t i = 0; i < points.size(); ++i)
      if ((points[i] - query).squaredNorm() < 1) corners.push_back(static_cast<std::int32_t>(i));
    ASSERT_EQ(corners.size(), 8U);
    const auto five = tree.nearest_few(query, 5);
    ASSERT_EQ(five.size(), 5U);
    for (std::size_t i = 0; i < five.size(); ++i) EXPECT_EQ(five[i].index, corners[i]);
  }
}

TEST(KdTree, TheLimitItselfIsWithin) {
  const KdTree tree({{3, 0, 0}, {0, 2, 0}});
  EXPECT_EQ(tree.nearest(Eigen::Vector3f::Zero(), 2).index, 1);
  EXPECT_EQ(tree.nearest(Eigen::Vector3f::Zero(), 1.999f).index, -1);
  EXPECT_EQ(tree.nearest({0, 2, 0}, 0).index, 1);
}

TEST(KdTree, GarbageIsNeverFound) {
  const KdTree empty({});
  EXPECT_EQ(empty.nearest(Eigen::Vector3f::Zero(), 1e9f).index, -1);
  const KdTree tree({Eigen::Vector3f::Constant(nan), Eigen::Vector3f::Ones()});
  EXPECT_EQ(tree.nearest(Eigen::Vector3f::Zero(), 1e9f).index, 1);
  EXPECT_EQ(tree.nearest(Eigen::Vector3f::Constant(nan), 1e9f).index, -1);
  EXPECT_EQ(tree.nearest(Eigen::Vector3f::Zero(), -1).index, -1);
  EXPECT_EQ(tree.size(), 1U);
  const auto few = tree.nearest_few(Eigen::Vector3f::Zero(), 5);
  ASSERT_EQ(few.size(), 1U);
  EXPECT_EQ(few[0].index, 1);
  EXPECT_TRUE(empty.nearest_few(Eigen::Vector3f::Zero(), 5).empty());
  const KdTree same(std::vector<Eigen::Vector3f>(1000, Eigen::Vector3f::Ones()));
  EXPECT_EQ(same.nearest(Eigen::Vector3f::Zero(), 1e9f).index, 0);
}

}  // namespace
}  // namespace lcmslam
