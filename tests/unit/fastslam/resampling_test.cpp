#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/fastslam/resampling.hpp>

namespace lcmslam {
namespace {

class Resampling : public testing::TestWithParam<ResamplingScheme> {};

std::vector<double> random_weights(Random& random, int n) {
  std::vector<double> logs;
  for (int i = 0; i < n; ++i) logs.push_back(1.5 * random.normal());
  return normalised_weights(logs);
}

struct Counts {
  std::vector<double> mean, variance;
};

Counts count_copies(const std::vector<double>& weights, ResamplingScheme scheme, int trials) {
  Random random(5);
  Counts counts{std::vector<double>(weights.size()), std::vector<double>(weights.size())};
  for (int t = 0; t < trials; ++t) {
    std::vector<int> copies(weights.size());
    for (const int a : resample(weights, scheme, random)) ++copies[static_cast<std::size_t>(a)];
    for (std::size_t i = 0; i < weights.size(); ++i) {
      counts.mean[i] += copies[i];
      counts.variance[i] += static_cast<double>(copies[i]) * copies[i];
    }
  }
  for (std::size_t i = 0; i < weights.size(); ++i) {
    counts.mean[i] /= trials;
    counts.variance[i] = counts.variance[i] / trials - counts.mean[i] * counts.mean[i];
  }
  return counts;
}

TEST_P(Resampling, ExpectedCopiesAreProportionalToWeights) {
  Random random(3);
  const std::vector<double> weights = random_weights(random, 12);
  const int trials = 40000;
  const Counts counts = count_copies(weights, GetParam(), trials);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    // 5 sigma of a multinomial's mean, the widest of the schemes.
    const double tolerance = 5 * std::sqrt(12 * weights[i] * (1 - weights[i]) / trials);
    EXPECT_NEAR(counts.mean[i], 12 * weights[i], tolerance) << i;
  }
}

TEST_P(Resampling, VarianceIsAtMostMultinomial) {
  Random random(4);
  const std::vector<double> weights = random_weights(random, 12);
  const Counts counts = count_copies(weights, GetParam(), 20000);
  double sum = 0, multinomial = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    sum += counts.variance[i];
    multinomial += 12 * weights[i] * (1 - weights[i]);
  }
  if (GetParam() == ResamplingScheme::multinomial)
    EXPECT_NEAR(sum, multinomial, 0.03 * multinomial);
  else
    EXPECT_LT(sum, 0.8 * multinomial);
}

TEST_P(Resampling, AncestorsAreAscendingAndComplete) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const std::vector<double> weights = random_weights(random, 1 + static_cast<int>(random.below(200)));
    const std::vector<int> ancestors = resample(weights, GetParam(), random);
    ASSERT_EQ(ancestors.size(), weights.size());
    EXPECT_TRUE(std::is_sorted(ancestors.begin(), ancestors.end()));
    EXPECT_GE(ancestors.front(), 0);
    EXPECT_LT(ancestors.back(), static_cast<int>(weights.size()));
  }
}

TEST_P(Resampling, OneCertainParticleTakesAll) {
  Random random(1);
  const std::vector<int> ancestors = resample({0, 0, 1, 0}, GetParam(), random);
  EXPECT_EQ(ancestors, (std::vector<int>{2, 2, 2, 2}));
}

INSTANTIATE_TEST_SUITE_P(Schemes, Resampling,
                         testing::Values(ResamplingScheme::multinomial, ResamplingScheme::systematic,
                                         ResamplingScheme::stratified, ResamplingScheme::residual));

// Only these two promise floor(n w) copies of a particle.
TEST(LowVarianceResampling, KeepsWholeCopies) {
  for (const auto scheme : {ResamplingScheme::systematic, ResamplingScheme::residual})
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      Random random(seed);
      const std::vector<double> weights = random_weights(random, 40);
      const std::vector<int> ancestors = resample(weights, scheme, random);
      for (int i = 0; i < 40; ++i)
        EXPECT_GE(std::count(ancestors.begin(), ancestors.end(), i),
                  std::floor(40 * weights[static_cast<std::size_t>(i)] - 1e-9))
            << "seed " << seed;
    }
}

// Strata that each lie half in one particle's part and half in the next one's: there the two schemes differ.
// Where all strata share one offset they all choose the same half, and every inner particle is drawn exactly
// once; with an offset for each stratum it is drawn 0, 1 or 2 times, with probability 1/4, 1/2 and 1/4.
TEST(LowVarianceResampling, StratifiedDrawsAnOffsetForEachStratumSystematicOneForAll) {
  constexpr int n = 40, trials = 2000;
  std::vector<double> weights(n, 1. / n);
  weights.front() = 0.5 / n;
  weights.back() = 1.5 / n;
  for (const auto scheme : {ResamplingScheme::systematic, ResamplingScheme::stratified}) {
    Random random(11);
    std::vector<int> times(4, 0);  // that an inner particle was drawn so often
    for (int t = 0; t < trials; ++t) {
      std::vector<int> copies(n);
      for (const int ancestor : resample(weights, scheme, random))
        ++copies[static_cast<std::size_t>(ancestor)];
      for (std::size_t i = 1; i + 1 < n; ++i) ++times.at(static_cast<std::size_t>(copies[i]));
    }
    constexpr double all = trials * (n - 2);
    EXPECT_EQ(times[3], 0);
    if (scheme == ResamplingScheme::systematic) {
      EXPECT_EQ(times[1], all);
    } else {
      EXPECT_NEAR(times[0] / all, 0.25, 0.01);
      EXPECT_NEAR(times[1] / all, 0.5, 0.01);
      EXPECT_NEAR(times[2] / all, 0.25, 0.01);
    }
  }
}

TEST(Weights, EffectiveSampleSize) {
  EXPECT_DOUBLE_EQ(effective_sample_size({0.25, 0.25, 0.25, 0.25}), 4);
  EXPECT_DOUBLE_EQ(effective_sample_size({0, 1, 0}), 1);
  EXPECT_DOUBLE_EQ(effective_sample_size({0.5, 0.5, 0}), 2);
}

TEST(Weights, LogWeightsOfAnySizeNormalise) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto far = normalised_weights({-1e5, -1e5 + std::log(3.0), nan});
  EXPECT_NEAR(far[0], 0.25, 1e-9);
  EXPECT_NEAR(far[1], 0.75, 1e-9);
  EXPECT_EQ(far[2], 0);
  EXPECT_EQ(normalised_weights({nan, nan}), (std::vector<double>{0.5, 0.5}));
}

}  // namespace
}  // namespace lcmslam
