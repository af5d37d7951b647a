#include <lcmslam/evaluation/consistency.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/evaluation/path_samples.hpp"

namespace lcmslam {
namespace {

Vector6d normal_twist(Random& random, const Vector6d& sigma) {
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi(i) = sigma(i) * random.normal();
  return xi;
}

// Errs by `sigma` and says so, times `claimed`.
Trajectory estimate_of(const Trajectory& truth, std::uint64_t seed, const Vector6d& sigma,
                       double claimed = 1) {
  Random random(seed);
  Trajectory estimate = truth;
  for (StampedPose& pose : estimate) {
    pose.T_world_body = pose.T_world_body * se3_exp(normal_twist(random, sigma));
    pose.covariance = Matrix6d((claimed * sigma).cwiseAbs2().asDiagonal());
  }
  return estimate;
}

const Vector6d typical_sigma = (Vector6d() << 0.03, 0.01, 0.02, 0.004, 0.006, 0.01).finished();

Consistency of(const Trajectory& truth, const Trajectory& estimate, Alignment alignment = Alignment::none) {
  EvaluationSettings settings;
  settings.alignment = alignment;
  return evaluate(truth, estimate, settings).consistency.value();
}

// Chi square of 6 * 2000 degrees of freedom: 6 +- 0.23 within three sigma; 95 % +- 1.5 %.
TEST(Consistency, OfHonestCovariancesIsTheNumberOfComponents) {
  const Trajectory truth = testing::curved_path(2000);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Consistency c = of(truth, estimate_of(truth, seed, typical_sigma));
    EXPECT_EQ(c.components, 6);
    EXPECT_NEAR(c.nees.mean, 6, 0.25) << "seed " << seed;
    EXPECT_NEAR(c.nees.median, 5.35, 0.3) << "seed " << seed;
    EXPECT_NEAR(c.inside, 0.95, 0.015) << "seed " << seed;
    EXPECT_NEAR(c.position_inside, 0.95, 0.015) << "seed " << seed;
    ASSERT_EQ(c.error_over_sigma.size(), 6U);
    for (const double ratio : c.error_over_sigma) EXPECT_NEAR(ratio, 1, 0.05) << "seed " << seed;
  }
}

TEST(Consistency, ShowsOverconfidence) {
  const Trajectory truth = testing::curved_path(2000);
  const Consistency c = of(truth, estimate_of(truth, 1, typical_sigma, 0.5));
  EXPECT_NEAR(c.nees.mean, 24, 1);
  EXPECT_LT(c.inside, 0.5);
  EXPECT_LT(c.position_inside, 0.7);
}

TEST(Consistency, OfAPathInThePlaneIsJudgedByThreeComponents) {
  Trajectory truth;
  for (int i = 0; i < 2000; ++i)
    truth.push_back({1'000'000 + 100'000 * static_cast<Utime>(i),
                     planar_pose(std::cos(0.01 * i), std::sin(0.01 * i), 0.01 * i)});
  Vector6d sigma = typical_sigma;
  sigma.segment<3>(2).setZero();
  const Consistency c = of(truth, estimate_of(truth, 1, sigma));
  EXPECT_EQ(c.components, 3);
  EXPECT_NEAR(c.nees.mean, 3, 0.17);
  EXPECT_NEAR(c.inside, 0.95, 0.015);
  EXPECT_NEAR(c.position_inside, 0.95, 0.015);
}

// The estimate stands in a world of its own. Its first poses are known much better than the others: a fit by
// paths alone would make them many sigma wrong.
TEST(Consistency, FitsTheWorldByTheCovariances) {
  const Trajectory truth = testing::curved_path(2000);
  Random random(3);
  Trajectory estimate = estimate_of(truth, 3, typical_sigma);
  for (std::size_t i = 0; i < 20; ++i) {
    estimate[i].T_world_body = truth[i].T_world_body * se3_exp(normal_twist(random, 1e-3 * typical_sigma));
    estimate[i].covariance = Matrix6d((1e-3 * typical_sigma).cwiseAbs2().asDiagonal());
  }
  const Consistency c = of(truth, testing::moved(estimate, testing::random_pose(random)), Alignment::se3);
  EXPECT_NEAR(c.nees.mean, 6, 0.25);
}

// A motion capture's body sits a degree beside the camera: that is no error of the estimate.
TEST(Consistency, FitsTheBodyWhereItIsAsked) {
  const Trajectory truth = testing::curved_path(2000);
  Random random(7);
  const Eigen::Isometry3d T_estimate_truth =
      se3_exp((Vector6d() << 0.02, -0.01, 0.005, 0.03, -0.02, 0.01).finished());
  const Trajectory estimate =
      testing::moved(in_other_frame(estimate_of(truth, 7, 0.2 * typical_sigma), T_estimate_truth.inverse()),
                     testing::random_pose(random));
  EvaluationSettings settings;
  EXPECT_GT(evaluate(truth, estimate, settings).consistency->nees.mean, 12);
  settings.fit_body = true;
  const Consistency c = evaluate(truth, estimate, settings).consistency.value();
  EXPECT_NEAR(c.nees.mean, 6, 0.25);
  EXPECT_LT(distance_between(c.T_estimate_truth, T_estimate_truth), 0.001);
  EXPECT_LT(angle_between(c.T_estimate_truth, T_estimate_truth), 0.001);
}

TEST(Consistency, IsTheSameOfAnotherFrameOfTheBody) {
  const Trajectory truth = testing::curved_path(300);
  const Trajectory estimate = estimate_of(truth, 4, 0.1 * typical_sigma);
  Random random(4);
  const Eigen::Isometry3d T_body_other = testing::random_pose(random, 0.3);
  const Consistency a = of(truth, estimate);
  const Consistency b = of(in_other_frame(truth, T_body_other), in_other_frame(estimate, T_body_other));
  EXPECT_NEAR(a.nees.mean, b.nees.mean, 1e-6);
}

// Of worlds that share the ground plane only place and heading in it are unknown: a tilt is an error.
TEST(Consistency, TakesNoMoreAwayThanTheAlignmentSays) {
  const Trajectory truth = testing::curved_path(2000);
  const Trajectory estimate = estimate_of(truth, 6, 0.2 * typical_sigma);
  const Eigen::Isometry3d beside = planar_pose(2, -1, 0.8);
  EXPECT_NEAR(of(truth, testing::moved(estimate, beside), Alignment::se2).nees.mean, 6, 0.25);
  const Eigen::Isometry3d tilted(Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitX()));
  EXPECT_GT(of(truth, testing::moved(estimate, beside * tilted), Alignment::se2).nees.mean, 60);
  const Eigen::Isometry3d above(Eigen::Translation3d(0, 0, 0.1));
  EXPECT_GT(of(truth, testing::moved(estimate, beside * above), Alignment::se2).nees.mean, 60);
}

TEST(Consistency, IsUnknownWithoutCovariances) {
  const Trajectory truth = testing::curved_path(300);
  EXPECT_FALSE(evaluate(truth, truth).consistency);
  Trajectory zero = truth;
  for (StampedPose& pose : zero) pose.covariance = Matrix6d::Zero();
  EXPECT_FALSE(evaluate(truth, zero).consistency);
}

}  // namespace
}  // namespace lcmslam
