#include <lcmslam/registration/metric.hpp>

#include <gtest/gtest.h>

#include "tests/unit/registration/random_pair.hpp"

namespace lcmslam {
namespace {

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

// The variance of one residual is the squared error by the weight: covariances stand on it.
TEST(Metric, SquaredErrorByWeightIsTheNoisesVariance) {
  constexpr double sigma = 0.02;
  constexpr int pairs = 20000;
  for (const MetricKind kind : {MetricKind::point_to_point, MetricKind::point_to_plane}) {
    RegistrationSettings settings;
    settings.metric = kind;
    const auto metric = make_metric(settings);
    Random random(3);
    const Eigen::Isometry3d T = random_transform(random);
    NormalEquations equations;
    for (int i = 0; i < pairs; ++i) {
      Pair pair = random_pair(random, T);
      pair.target = pair.moved + sigma * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
      metric->add(pair, T.linear(), equations);
    }
    EXPECT_NEAR(equations.squared_error / equations.weight, sigma * sigma, 0.05 * sigma * sigma);
  }
}

// What lies off either surface counts, what slides along both does not.
TEST(Metric, PlaneToPlaneKnowsBothSurfaces) {
  RegistrationSettings settings;
  settings.metric = MetricKind::plane_to_plane;
  const auto metric = make_metric(settings);
  Pair pair;
  pair.target_normal = Eigen::Vector3d::UnitX();
  pair.moved_normal = Eigen::Vector3d::UnitY();
  const auto error = [&](const Eigen::Vector3d& apart) {
    pair.target = pair.moved + apart;
    return metric->squared_error(pair);
  };
  EXPECT_NEAR(error(Eigen::Vector3d::UnitX()), error(Eigen::Vector3d::UnitY()), 1e-9);
  EXPECT_LT(error(Eigen::Vector3d::UnitZ()), 0.6 * error(Eigen::Vector3d::UnitX()));
}

}  // namespace
}  // namespace lcmslam
