#include <lcmslam/features/projection.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/features/guided_scene.hpp"

namespace lcmslam {
namespace {

using test::diagonal;
using test::empty_frame;
using test::random_twist;

TEST(Projection, JacobiansAreTheNumericalOnes) {
  const FeatureFrame frame = empty_frame();
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const Eigen::Isometry3d T_world_camera = se3_exp(random_twist(random, 1, 1));
    MapPoint point;
    point.position =
        T_world_camera * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(1, 5));
    const auto projection = project(point, T_world_camera, frame);
    ASSERT_TRUE(projection);
    constexpr double step = 1e-6;
    for (int k = 0; k < 6; ++k) {
      const auto at = [&](double h) {
        return project(point, T_world_camera * se3_exp(h * Vector6d::Unit(k)), frame)->pixel;
      };
      const Eigen::Vector2d numerical = (at(step) - at(-step)) / (2 * step);
      EXPECT_LT((projection->by_pose.col(k) - numerical).norm(), 1e-4) << "seed " << seed << " pose " << k;
    }
    for (int k = 0; k < 3; ++k) {
      const auto at = [&](double h) {
        MapPoint moved = point;
        moved.position[k] += h;
        return project(moved, T_world_camera, frame)->pixel;
      };
      const Eigen::Vector2d numerical = (at(step) - at(-step)) / (2 * step);
      EXPECT_LT((projection->by_point.col(k) - numerical).norm(), 1e-4) << "seed " << seed << " point " << k;
    }
  }
}

// innovation' S^-1 innovation has mean 2 and below 9.21 lie 99 %, when everything is drawn from what
// is stated.
TEST(Projection, TheInnovationIsAsLargeAsItsCovarianceSays) {
  const FeatureFrame frame = empty_frame();
  Random random(1);
  constexpr int runs = 4000;
  double sum = 0;
  int inside = 0;
  for (int i = 0; i < runs; ++i) {
    PredictedPose pose;
    pose.T_world_camera = se3_exp(random_twist(random, 1, 1));
    pose.covariance = diagonal(0.02, 0.01);
    const Eigen::Isometry3d truth = pose.T_world_camera * se3_exp(random_twist(random, 0.02, 0.01));
    MapPoint point;
    point.position = pose.T_world_camera *
                     Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(2, 5));
    point.covariance = 4e-4 * Eigen::Matrix3d::Identity();
    MapPoint actual = point;
    for (int k = 0; k < 3; ++k) actual.position[k] += 0.02 * random.normal();
    const auto predicted = project(point, pose.T_world_camera, frame), seen = project(actual, truth, frame);
    const Eigen::Vector2d innovation =
        seen->pixel + Eigen::Vector2d(random.normal(), random.normal()) - predicted->pixel;
    const Eigen::Matrix2d S = innovation_covariance(*predicted, point, pose, frame);
    const double squared = innovation.dot(S.llt().solve(innovation));
    sum += squared;
    inside += squared < GuidedSettings{}.chi_square;
  }
  EXPECT_NEAR(sum / runs, 2, 0.1);  // standard deviation 2 / sqrt(4000) = 0.03
  EXPECT_NEAR(double(inside) / runs, 0.99, 0.006);
}

TEST(Projection, PointsBehindTheCameraOrNotFiniteHaveNone) {
  MapPoint point;
  point.position = {0, 0, -1};
  EXPECT_FALSE(project(point, Eigen::Isometry3d::Identity(), empty_frame()));
  point.position = {0, 0, 0.05};
  EXPECT_FALSE(project(point, Eigen::Isometry3d::Identity(), empty_frame()));
  point.position = {NAN, 0, 1};
  EXPECT_FALSE(project(point, Eigen::Isometry3d::Identity(), empty_frame()));
}

}  // namespace
}  // namespace lcmslam
