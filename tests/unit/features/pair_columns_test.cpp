#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cstring>

#include <lcmslam/features/pair_columns.hpp>
#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

Eigen::Vector3d drawn(Random& random) {
  return {random.normal(), random.normal(), random.normal()};
}

Eigen::Matrix3d drawn_covariance(Random& random) {
  Eigen::Matrix3d root;
  for (int k = 0; k < 3; ++k) root.col(k) = 0.1 * drawn(random);
  return root * root.transpose() + 1e-4 * Eigen::Matrix3d::Identity();
}

std::vector<PointPair> drawn_pairs(int count, Random& random) {
  std::vector<PointPair> pairs;
  for (int i = 0; i < count; ++i)
    pairs.push_back({drawn(random), drawn(random), drawn_covariance(random), drawn_covariance(random)});
  return pairs;
}

Eigen::Isometry3d drawn_motion(Random& random) {
  Vector6d twist;
  twist << drawn(random), drawn(random);
  return se3_exp(twist);
}

// More than one batch, and a last one that fills no register.
constexpr int several = 2 * PairResiduals::most + 3;

TEST(PairColumns, GivesTheResidualOfEachPairAndItsInformation) {
  Random random(5, 1);
  const std::vector<PointPair> pairs = drawn_pairs(several, random);
  const Eigen::Isometry3d T = drawn_motion(random);
  const Eigen::Matrix3d R = T.linear();
  const PairColumns columns(pairs);
  PairResiduals residuals;
  int first = 0;
  while (first < columns.size()) {
    const int count = columns.measure(T, first, residuals);
    ASSERT_GT(count, 0);
    for (int i = 0; i < count; ++i) {
      const PointPair& pair = pairs[std::size_t(first + i)];
      const Eigen::Vector3d error = T.inverse() * pair.point_a - pair.point_b;
      const Eigen::Matrix3d information =
          (R.transpose() * pair.covariance_a * R + pair.covariance_b).inverse();
      const double near = 1e-9 * information.norm();
      for (int row = 0, upper = 0; row < 3; ++row) {
        EXPECT_NEAR(residuals.error[row][i], error[row], 1e-12);
        for (int k = row; k < 3; ++k, ++upper)
          EXPECT_NEAR(residuals.information[upper][i], information(row, k), near);
      }
      const double distance2 = error.dot(information * error);
      EXPECT_NEAR(residuals.distance2[i], distance2, 1e-9 * distance2);
      EXPECT_EQ(columns.point_b(first + i), pair.point_b);
    }
    first += count;
  }
  EXPECT_EQ(first, several);
}

TEST(PairColumns, TakesThePairsThatAreNamed) {
  Random random(6, 1);
  const std::vector<PointPair> pairs = drawn_pairs(5, random);
  const PairColumns columns(pairs, {4, 1});
  ASSERT_EQ(columns.size(), 2);
  EXPECT_EQ(columns.point_b(0), pairs[4].point_b);
  EXPECT_EQ(columns.point_b(1), pairs[1].point_b);
}

TEST(PairColumns, AllInstructionSetsGiveTheSameBits) {
  Random random(7, 1);
  const PairColumns columns(drawn_pairs(PairResiduals::most, random));
  const Eigen::Isometry3d T = drawn_motion(random);
  PairResiduals best, portable;
  columns.measure(T, 0, best);
  const InstructionSet limit = limit_instruction_set(InstructionSet::portable);
  columns.measure(T, 0, portable);
  limit_instruction_set(limit);
  EXPECT_EQ(std::memcmp(&best, &portable, sizeof best), 0);
}

}  // namespace
}  // namespace lcmslam
