#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/features/matching.hpp>
#include <lcmslam/geometry/random.hpp>
#include "tests/support/heap_allocations.hpp"

namespace lcmslam {
namespace {

Descriptor random_descriptor(Random& random) {
  Descriptor descriptor;
  for (auto& byte : descriptor) byte = static_cast<std::uint8_t>(random.below(256));
  return descriptor;
}

// b holds disturbed copies of some of a, in another order, and strangers.
void make_sets(std::uint64_t seed, std::size_t size_a, std::size_t size_b, std::vector<Feature>& a,
               std::vector<Feature>& b) {
  Random random(seed);
  a.resize(size_a);
  b.resize(size_b);
  for (Feature& f : a) {
    f.descriptor = random_descriptor(random);
    f.laplacian = random.uniform() < 0.5 ? std::int8_t(-1) : std::int8_t(1);
  }
  for (std::size_t j = 0; j < size_b; ++j) {
    b[j].descriptor = random_descriptor(random);
    b[j].laplacian = random.uniform() < 0.5 ? std::int8_t(-1) : std::int8_t(1);
    if (size_a == 0 || j % 3 == 0) continue;
    const Feature& source = a[random.below(size_a)];
    b[j].laplacian = source.laplacian;
    for (std::size_t k = 0; k < 64; ++k)
      b[j].descriptor[k] =
          static_cast<std::uint8_t>(std::clamp(source.descriptor[k] + int(random.below(121)) - 60, 0, 255));
  }
}

int plain_distance(const Feature& a, const Feature& b) {
  int sum = 0;
  for (std::size_t k = 0; k < 64; ++k)
    sum += (int(a.descriptor[k]) - b.descriptor[k]) * (int(a.descriptor[k]) - b.descriptor[k]);
  return sum;
}

std::vector<Match> plain_match(const std::vector<Feature>& a, const std::vector<Feature>& b, double ratio,
                               bool same) {
  std::vector<Match> matches;
  const auto admitted = [&](std::size_t i, std::size_t j) {
    return !same || a[i].laplacian == b[j].laplacian;
  };
  for (std::size_t i = 0; i < a.size(); ++i) {
    int nearest = -1, distance = 0;
    for (std::size_t j = 0; j < b.size(); ++j)
      if (admitted(i, j) && (nearest < 0 || plain_distance(a[i], b[j]) < distance)) {
        nearest = int(j);
        distance = plain_distance(a[i], b[j]);
      }
    if (nearest < 0) continue;
    bool kept = true;
    for (std::size_t j = 0; j < b.size(); ++j)
      if (admitted(i, j) && int(j) != nearest && ratio < 1 &&
          !(std::sqrt(distance) < ratio * std::sqrt(plain_distance(a[i], b[j]))))
        kept = false;
    for (std::size_t other = 0; other < a.size(); ++other)
      if (other != i && admitted(other, std::size_t(nearest))) {
        const int competing = plain_distance(a[other], b[std::size_t(nearest)]);
        if (competing < distance || (competing == distance && other < i)) kept = false;
      }
    if (kept) matches.push_back({int(i), nearest, distance});
  }
  return matches;
}

TEST(Matching, EqualsBruteForce) {
  std::size_t total = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    std::vector<Feature> a, b;
    make_sets(seed, 10 * seed, 150 - 10 * seed, a, b);
    for (double ratio : {0.6, 0.8, 1.0})
      for (bool same : {true, false}) {
        const auto found = match(a, b, {ratio, same}), expected = plain_match(a, b, ratio, same);
        ASSERT_EQ(found.size(), expected.size()) << "seed " << seed << " ratio " << ratio;
        for (std::size_t i = 0; i < found.size(); ++i) {
          EXPECT_EQ(found[i].a, expected[i].a);
          EXPECT_EQ(found[i].b, expected[i].b);
          EXPECT_EQ(found[i].distance2, expected[i].distance2);
        }
        total += found.size();
      }
  }
  EXPECT_GT(total, 500u);
}

TEST(Matching, EveryInstructionSetGivesTheSameMatches) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::vector<Feature> a, b;
    make_sets(seed, 3 + 13 * seed, 300 - 13 * seed, a, b);
    const auto expected = Matcher(InstructionSet::portable).match(a, b);
    for (const InstructionSet set : {InstructionSet::sse2, InstructionSet::avx2}) {
      if (!has(set)) continue;
      Matcher matcher(set);
      const auto& found = matcher.match(a, b);
      ASSERT_EQ(found.size(), expected.size()) << "seed " << seed << ", set " << int(set);
      for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].a, expected[i].a);
        EXPECT_EQ(found[i].b, expected[i].b);
        EXPECT_EQ(found[i].distance2, expected[i].distance2);
      }
    }
  }
}

TEST(Matching, AMatcherForgetsThePairBefore) {
  Matcher matcher;
  std::vector<Feature> a, b, c, d;
  make_sets(1, 200, 300, a, b);
  make_sets(2, 50, 40, c, d);
  const auto fresh = match(c, d);
  matcher.match(a, b);
  const auto& again = matcher.match(c, d);
  ASSERT_EQ(again.size(), fresh.size());
  for (std::size_t i = 0; i < fresh.size(); ++i) EXPECT_EQ(again[i].b, fresh[i].b);
}

TEST(Matching, AMatcherAllocatesNothingOnceWarm) {
  Matcher matcher;
  std::vector<Feature> a, b;
  make_sets(3, 400, 500, a, b);
  matcher.match(a, b);
  const long before = heap_allocations();
  const std::size_t found = matcher.match(a, b).size();
  EXPECT_EQ(heap_allocations(), before);
  EXPECT_GT(found, 0u);
}

TEST(Matching, ExtremeBytesDoNotOverflow) {
  std::vector<Descriptor> a(2), b(2);
  a[0].fill(0);
  a[1].fill(255);
  b[0].fill(254);
  b[1].fill(1);
  EXPECT_EQ(squared_distance(a[0], a[1]), 64 * 255 * 255);
  const auto matches = match(a, b);
  ASSERT_EQ(matches.size(), 2u);
  EXPECT_EQ(matches[0].b, 1);
  EXPECT_EQ(matches[0].distance2, 64);
  EXPECT_EQ(matches[1].b, 0);
}

TEST(Matching, TheRatioIsOfDistancesNotOfSquares) {
  std::vector<Descriptor> a(1), b(2);
  a[0].fill(100);
  b[0] = b[1] = a[0];
  b[0][0] = 107;  // distance 7
  b[1][0] = 110;  // distance 10
  EXPECT_EQ(match(a, b, 0.75).size(), 1u);
  EXPECT_EQ(match(a, b, 0.65).size(), 0u);
}

TEST(Matching, TwinsAreAmbiguousAndEmptySetsHaveNoMatches) {
  std::vector<Descriptor> a(1), twins(2);
  a[0].fill(9);
  twins[0].fill(9);
  twins[1].fill(9);
  EXPECT_TRUE(match(a, twins).empty());
  ASSERT_EQ(match(a, twins, 1).size(), 1u);
  EXPECT_EQ(match(a, twins, 1)[0].b, 0);
  EXPECT_TRUE(match(a, {}).empty());
  EXPECT_TRUE(match(std::vector<Descriptor>{}, a).empty());
  EXPECT_EQ(match(a, {twins[0]}).size(), 1u);
}

TEST(Matching, OppositeSignsNeverMatch) {
  std::vector<Feature> a(1), b(1);
  a[0].laplacian = 1;
  b[0].laplacian = -1;
  EXPECT_TRUE(match(a, b).empty());
  EXPECT_EQ(match(a, b, {0.8, false}).size(), 1u);
}

TEST(Matching, RefusesARatioOutOfRange) {
  EXPECT_THROW(match(std::vector<Feature>{}, {}, {0, true}), std::invalid_argument);
  EXPECT_THROW(match(std::vector<Feature>{}, {}, {1.5, true}), std::invalid_argument);
  EXPECT_THROW(match(std::vector<Descriptor>{}, {}, NAN), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
