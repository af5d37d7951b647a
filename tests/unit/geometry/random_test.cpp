#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

constexpr int draws = 200000;

TEST(Random, SameSeedAndStreamRepeat) {
  Random a(7, 3);
  Random b(7, 3);
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(a.bits(), b.bits());
}

TEST(Random, SeedsAndStreamsDiffer) {
  std::vector<std::uint64_t> first;
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    for (std::uint64_t stream = 0; stream < 20; ++stream) first.push_back(Random(seed, stream).bits());
  std::sort(first.begin(), first.end());
  EXPECT_EQ(std::adjacent_find(first.begin(), first.end()), first.end());
}

// Correlation of n independent pairs is within 5 / sqrt(n) but for one run in two million.
TEST(Random, StreamsOfOneSeedAreUncorrelated) {
  Random a(1, 0);
  Random b(1, 1);
  double sum = 0;
  for (int i = 0; i < draws; ++i) sum += a.normal() * b.normal();
  EXPECT_LT(std::abs(sum / draws), 5 / std::sqrt(draws));
}

TEST(Random, UniformHasItsMoments) {
  Random random(2);
  double sum = 0, squares = 0;
  for (int i = 0; i < draws; ++i) {
    const double u = random.uniform(-1, 3);
    ASSERT_GE(u, -1);
    ASSERT_LT(u, 3);
    sum += u;
    squares += (u - 1) * (u - 1);
  }
  const double variance = 16.0 / 12.0;
  EXPECT_NEAR(sum / draws, 1, 5 * std::sqrt(variance / draws));
  EXPECT_NEAR(squares / draws, variance, 0.02 * variance);
}

TEST(Random, NormalHasItsMoments) {
  Random random(3);
  std::array<double, 5> moment{};
  for (int i = 0; i < draws; ++i) {
    const double x = random.normal(1, 2);
    const double z = (x - 1) / 2;
    for (std::size_t k = 1; k < 5; ++k) moment[k] += std::pow(z, static_cast<double>(k)) / draws;
  }
  const double n = std::sqrt(draws);
  EXPECT_NEAR(moment[1], 0, 5 * 1 / n);
  EXPECT_NEAR(moment[2], 1, 5 * std::sqrt(2) / n);
  EXPECT_NEAR(moment[3], 0, 5 * std::sqrt(15) / n);
  EXPECT_NEAR(moment[4], 3, 5 * std::sqrt(96) / n);
}

TEST(Random, BelowIsEven) {
  Random random(4);
  std::array<int, 7> count{};
  for (int i = 0; i < draws; ++i) ++count.at(static_cast<std::size_t>(random.below(7)));
  const double expected = draws / 7.0;
  for (const int c : count) EXPECT_NEAR(c, expected, 5 * std::sqrt(expected));
}

}  // namespace
}  // namespace lcmslam
