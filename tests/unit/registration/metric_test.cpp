// Linearisation, weights and rejection.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include <lcmslam/registration/rejection.hpp>
#include <lcmslam/registration/weighting.hpp>
#include "tests/unit/geometry/random_poses.hpp"

namespace lcmslam {
namespace {

Pair random_pair(Random& random, const Eigen::Isometry3d& T) {
  Pair p;
  p.source = random_vector(random, 1);
  p.moved = T * p.source;
  p.target = p.moved + random_vector(random, 0.1);
  p.target_normal = random_vector(random, 1).normalized();
  p.moved_normal = random_vector(random, 1).normalized();
  p.weight = random.uniform(0.5, 2);
  p.source_intensity = random.uniform();
  p.target_intensity = random.uniform();
  p.target_gradient = random_vector(random, 1);
  return p;
}

// Each metric, without and with the colour term.
class MetricJacobian : public testing::TestWithParam<std::tuple<MetricKind, double>> {
 protected:
  static std::unique_ptr<Metric> metric() {
    RegistrationSettings settings;
    std::tie(settings.metric, settings.colour_scale) = GetParam();
    return make_metric(settings);
  }
};
INSTANTIATE_TEST_SUITE_P(Metrics, MetricJacobian,
                         testing::Combine(testing::Values(MetricKind::point_to_point,
                                                          MetricKind::point_to_plane,
                                                          MetricKind::plane_to_plane),
                                          testing::Values(0.0, 0.3)));

// The gradient of w r^2 / 2 is -b, its second derivative along a direction d is d^T H d (the
// residuals are linear in the translation and, to first order, in the rotation).
TEST_P(MetricJacobian, AgreesWithNumericDerivatives) {
  const auto metric = MetricJacobian::metric();
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Eigen::Isometry3d T = random_transform(random);
    const Pair pair = random_pair(random, T);
    NormalEquations equations;
    metric->add(pair, T.linear(), equations);
    const auto half_cost = [&](const Vector6d& xi) {
      Pair p = pair;
      p.moved = T * se3_exp(xi) * p.source;
      return 0.5 * p.weight * metric->squared_error(p);
    };
    constexpr double h = 1e-5;
    for (int i = 0; i < 6; ++i) {
      const double numeric = (half_cost(h * Vector6d::Unit(i)) - half_cost(-h * Vector6d::Unit(i))) / (2 * h);
      EXPECT_NEAR(-equations.b(i), numeric, 1e-8);
    }
    EXPECT_NEAR(equations.squared_error, 2 * half_cost(Vector6d::Zero()), 1e-12);
    EXPECT_LT((equations.H - equations.H.transpose()).norm(), 1e-12);
  }
}

// With the residual zero, H is the exact second derivative in all six directions.
TEST_P(MetricJacobian, HessianIsExactAtZeroResidual) {
  const auto metric = MetricJacobian::metric();
  Random random(99);
  const Eigen::Isometry3d T = random_transform(random);
  Pair pair = random_pair(random, T);
  pair.target = pair.moved;
  pair.target_intensity = pair.source_intensity;
  NormalEquations equations;
  metric->add(pair, T.linear(), equations);
  constexpr double h = 1e-4;
  for (int k = 0; k < 30; ++k) {
    Vector6d d;
    d << random_vector(random, 1), random_vector(random, 1);
    Pair p = pair;
    p.moved = T * se3_exp(h * d) * p.source;
    EXPECT_NEAR(p.weight * metric->squared_error(p) / (h * h), d.dot(equations.H * d),
                3e-3 * d.squaredNorm());
  }
}

// w(s) s is the derivative of the kernel's loss: Huber's is linear beyond its width, Geman and
// McClure's is s^2 / (2 (1 + s^2 / k^2)).
TEST(RobustKernel, WeightsAreDerivativesOfTheLoss) {
  const double k = 2;
  const HuberKernel huber(k);
  const GemanMcClureKernel geman(k);
  const auto huber_loss = [&](double s) { return s <= k ? 0.5 * s * s : k * s - 0.5 * k * k; };
  const auto geman_loss = [&](double s) { return 0.5 * s * s / (1 + s * s / (k * k)); };
  constexpr double h = 1e-6;
  for (const double s : {0.1, 1.0, 1.9, 2.1, 5.0, 20.0}) {
    EXPECT_NEAR(huber.weight(s * s) * s, (huber_loss(s + h) - huber_loss(s - h)) / (2 * h), 1e-8);
    EXPECT_NEAR(geman.weight(s * s) * s, (geman_loss(s + h) - geman_loss(s - h)) / (2 * h), 1e-8);
  }
  EXPECT_EQ(NoKernel().weight(1e9), 1);
}

TEST(Weighting, OutliersLoseTheirInfluence) {
  Random random(3);
  std::vector<Pair> pairs;
  for (int i = 0; i < 100; ++i) {
    Pair p = random_pair(random, Eigen::Isometry3d::Identity());
    p.variance = 1e-4;
    p.target = p.moved + random.normal(0, i < 90 ? 0.01 : 1.0) * p.target_normal;
    pairs.push_back(p);
  }
  weigh_pairs(pairs, PointToPlane(), GemanMcClureKernel(2.5), true);
  double inlier = 0, outlier = 0;
  for (std::size_t i = 0; i < 100; ++i) (i < 90 ? inlier : outlier) += pairs[i].weight;
  EXPECT_GT(inlier / 90, 0.5e4);
  EXPECT_LT(outlier / 10, 0.2 * inlier / 90);
}

TEST(Weighting, NoisierPairsCountLess) {
  Random random(4);
  std::vector<Pair> pairs(2, random_pair(random, Eigen::Isometry3d::Identity()));
  pairs[0].variance = 1;
  pairs[1].variance = 4;
  weigh_pairs(pairs, PointToPlane(), NoKernel(), true);
  EXPECT_DOUBLE_EQ(pairs[0].weight, 4 * pairs[1].weight);
  weigh_pairs(pairs, PointToPlane(), NoKernel(), false);
  EXPECT_DOUBLE_EQ(pairs[0].weight, pairs[1].weight);
}

TEST(Rejection, NormalAngle) {
  std::vector<Pair> pairs;
  for (const double angle : {0.0, 0.4, 0.6, 3.0, std::numeric_limits<double>::quiet_NaN()}) {
    Pair p;
    p.moved_normal = Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    p.target_normal = Eigen::Vector3d::UnitX();
    pairs.push_back(p);
  }
  NormalAngleRejector(0.5).reject(pairs, Eigen::Isometry3d::Identity());
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_EQ(pairs[1].moved_normal.x(), std::cos(0.4));
  EXPECT_TRUE(std::isnan(pairs[2].moved_normal.x()));  // unknown normals pass
}

TEST(Rejection, TrimmedKeepsTheNearest) {
  std::vector<Pair> pairs;
  for (const double d : {5.0, 1.0, 4.0, 2.0, 3.0}) {
    Pair p;
    p.moved = Eigen::Vector3d(d, 0, 0);
    p.target.setZero();
    pairs.push_back(p);
  }
  TrimmedRejector(0.6).reject(pairs, Eigen::Isometry3d::Identity());
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_EQ(pairs[0].moved.x(), 1);
  EXPECT_EQ(pairs[1].moved.x(), 2);
  EXPECT_EQ(pairs[2].moved.x(), 3);
}

TEST(Rejection, PlanesNeedNormals) {
  std::vector<Pair> pairs(2);
  pairs[0].target_normal = Eigen::Vector3d::UnitX();
  pairs[1].target_normal.setConstant(std::numeric_limits<double>::quiet_NaN());
  MissingNormalRejector().reject(pairs, Eigen::Isometry3d::Identity());
  EXPECT_EQ(pairs.size(), 1u);
}

}  // namespace
}  // namespace lcmslam
