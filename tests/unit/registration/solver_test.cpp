#include <lcmslam/registration/solver.hpp>

#include <gtest/gtest.h>

#include "tests/unit/registration/random_pair.hpp"

namespace lcmslam {
namespace {

class ClosedForm : public testing::TestWithParam<SolverKind> {
 protected:
  static std::unique_ptr<Solver> solver() {
    RegistrationSettings settings;
    settings.metric = MetricKind::point_to_point;
    settings.solver = GetParam();
    return make_solver(settings, nullptr);
  }
  /// Pairs of points that T_true brings together, seen from T.
  static std::vector<Pair> pairs_of(const Eigen::Isometry3d& T_true, const Eigen::Isometry3d& T,
                                    Random& random) {
    std::vector<Pair> pairs;
    for (int i = 0; i < 50; ++i) {
      pairs.push_back(random_pair(random, T));
      pairs.back().target = T_true * pairs.back().source;
    }
    return pairs;
  }
};
INSTANTIATE_TEST_SUITE_P(Solvers, ClosedForm, testing::Values(SolverKind::svd, SolverKind::quaternion));

TEST_P(ClosedForm, FindsExactPairsInOneStepFromAnywhere) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const Eigen::Isometry3d T_true = random_transform(random), T = random_transform(random);
    const auto found = solver()->solve(pairs_of(T_true, T, random), T);
    ASSERT_TRUE(found) << seed;
    EXPECT_TRUE(found->isApprox(T_true, 1e-9)) << seed;
  }
}

TEST_P(ClosedForm, PairsCountByTheirWeights) {
  Random random(5);
  const Eigen::Isometry3d T_true = random_transform(random), T = random_transform(random);
  std::vector<Pair> pairs = pairs_of(T_true, T, random);
  for (std::size_t i = 0; i < pairs.size(); i += 2) {  // half of them are wrong and count for nothing
    pairs[i].target += Eigen::Vector3d(1, 2, 3);
    pairs[i].weight = 1e-12;
  }
  EXPECT_TRUE(solver()->solve(pairs, T)->isApprox(T_true, 1e-6));
}

std::vector<Pair> random_pairs(Random& random, const Eigen::Isometry3d& T, int count) {
  std::vector<Pair> pairs;
  for (int i = 0; i < count; ++i) pairs.push_back(random_pair(random, T));
  return pairs;
}

// Pairs that contradict each other, far from the minimum: there a full step may lead uphill.
TEST(LevenbergMarquardt, NoStepMakesTheErrorLarger) {
  RegistrationSettings settings;
  const auto metric = make_metric(settings);
  const auto cost = [&](std::vector<Pair> pairs, const Eigen::Isometry3d& T) {
    double sum = 0;
    for (Pair& p : pairs) {
      p.moved = T * p.source;
      sum += p.weight * metric->squared_error(p);
    }
    return sum;
  };
  int uphill = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(seed);
    const Eigen::Isometry3d T = random_transform(random);
    std::vector<Pair> pairs = random_pairs(random, T, 8);
    for (Pair& p : pairs) p.target = random_vector(random, 2);
    const auto full = GaussNewtonSolver(settings, nullptr).solve(pairs, T);
    uphill += full && cost(pairs, *full) > cost(pairs, T) ? 1 : 0;
    const auto damped = LevenbergMarquardtSolver(settings, nullptr).solve(pairs, T);
    ASSERT_TRUE(damped);
    EXPECT_LE(cost(pairs, *damped), cost(pairs, T) * (1 + 1e-9)) << seed;
  }
  EXPECT_GT(uphill, 5) << "else this tests nothing";
}

// Neighbouring points err alike: beyond independent_pairs more of them tell no more.
TEST(Observability, MorePairsThanAreIndependentTellNothingNew) {
  RegistrationSettings settings;
  settings.independent_pairs = 100;
  const auto metric = make_metric(settings);
  Random random(9);
  const Eigen::Isometry3d T = random_transform(random);
  const std::vector<Pair> some = random_pairs(random, T, 200);
  std::vector<Pair> twice = some;
  twice.insert(twice.end(), some.begin(), some.end());
  const Matrix6d covariance = observe(some, *metric, T, settings).covariance(nullptr);
  EXPECT_TRUE(observe(twice, *metric, T, settings).covariance(nullptr).isApprox(covariance, 1e-9));
}

/// On planes that T brings them to but for noise of `noise` (m), weighed by what `assumed` (m) says.
std::vector<Pair> noisy_pairs(Random& random, const Eigen::Isometry3d& T, double noise, double assumed) {
  std::vector<Pair> pairs = random_pairs(random, T, 500);
  for (Pair& p : pairs) {
    p.target = p.moved + random.normal(0, noise) * p.target_normal;
    p.variance = assumed * assumed;
    p.weight = 1 / p.variance;
  }
  return pairs;
}

// Pairs that err by three times what they are said to leave the result three times less sure; of pairs that
// err by half of it nothing is believed away.
TEST(Observability, WhatPairsErrByBeyondTheirNoiseIsDoubt) {
  const RegistrationSettings settings;
  const auto metric = make_metric(settings);
  Random random(3);
  const Eigen::Isometry3d T = random_transform(random);
  const auto told = [&](double noise) {
    Random same(4);
    return observe(noisy_pairs(same, T, noise, 0.01), *metric, T, settings).covariance(nullptr);
  };
  const Matrix6d as_assumed = told(0.001);
  EXPECT_TRUE(told(0.005).isApprox(as_assumed, 1e-9));
  const Matrix6d tripled = told(0.03);
  EXPECT_TRUE(tripled.isApprox(9 * as_assumed, 0.15)) << tripled.norm() / as_assumed.norm();
}

// A start that is off is no noise: pairs that are as sure as a prior draw it half the way.
TEST(GaussNewton, PairsFarFromTheStartCountAsTheirNoiseSays) {
  const RegistrationSettings settings;
  Random random(5);
  const Eigen::Isometry3d T = random_transform(random);
  const Vector6d way = (Vector6d() << 0.3, 0.2, -0.1, 0, 0, 0).finished();
  std::vector<Pair> pairs = noisy_pairs(random, T, 0, 0.01);
  const Observability seen = observe(pairs, *make_metric(settings), T, settings);
  const Eigen::Isometry3d T_start = T * se3_exp(-way);
  for (Pair& p : pairs) p.moved = T_start * p.source;
  const Matrix6d to_twist = seen.basis.inverse();
  const Prior prior{T_start, to_twist.transpose() * seen.information * to_twist};
  const auto reached = GaussNewtonSolver(settings, &prior).solve(pairs, T_start);
  ASSERT_TRUE(reached);
  EXPECT_LT((se3_log(T_start.inverse() * *reached) - 0.5 * way).norm(), 1e-6);
}

}  // namespace
}  // namespace lcmslam
