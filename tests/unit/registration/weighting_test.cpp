#include <lcmslam/registration/weighting.hpp>

#include <gtest/gtest.h>

#include "tests/unit/registration/random_pair.hpp"

namespace lcmslam {
namespace {

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

TEST(Weighting, YoungSurfacesLeadOnlyWhereThereAreNoOthers) {
  Random random(5);
  std::vector<Pair> pairs(100, random_pair(random, Eigen::Isometry3d::Identity()));
  const auto weight_with = [&](std::size_t settled) {
    for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].young = i >= settled;
    weigh_pairs(pairs, PointToPlane(), NoKernel(), true, true);
    return pairs.back().weight / pairs.front().weight;
  };
  const double settled = [&] {
    for (Pair& p : pairs) p.young = false;
    weigh_pairs(pairs, PointToPlane(), NoKernel(), true);
    return pairs.back().weight;
  }();
  EXPECT_DOUBLE_EQ(weight_with(0), 1);
  EXPECT_DOUBLE_EQ(pairs.back().weight, settled);
  EXPECT_LT(weight_with(20), 0.5);
  EXPECT_LT(weight_with(40), 0.01);
  EXPECT_GT(pairs.back().weight, 0);
  EXPECT_DOUBLE_EQ(pairs.front().weight, settled);
  weigh_pairs(pairs, PointToPlane(), NoKernel(), true);
  EXPECT_DOUBLE_EQ(pairs.back().weight, settled) << "unless somebody asks for it";
}

}  // namespace
}  // namespace lcmslam
