// Directions that the clouds leave free.

#include <gtest/gtest.h>

#include <cmath>

#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/registration.hpp>
#include "tests/support/cloud_scenes.hpp"
#include "tests/unit/registration/register_to_itself.hpp"

namespace lcmslam {
namespace {

// Degenerate directions are those whose motion leaves all residuals at zero.
void expect_degenerate(const Cloud& cloud, std::size_t directions) {
  const RegistrationResult r = register_to_itself(cloud, Eigen::Isometry3d::Identity());
  ASSERT_EQ(r.degenerate.size(), directions);
  for (const Vector6d& xi : r.degenerate) {
    double sum = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3d p = cloud.points[i].cast<double>();
      const double slide = cloud.normals[i].cast<double>().dot(xi.head<3>() + xi.tail<3>().cross(p));
      sum += slide * slide;
    }
    EXPECT_LT(std::sqrt(sum / static_cast<double>(cloud.size())), 1e-3);
  }
  EXPECT_GT(r.covariance.diagonal().maxCoeff(), 0.01);
}

TEST(Degeneracy, AWallLeavesThreeDirections) {
  expect_degenerate(wall(), 3);
}
TEST(Degeneracy, ACorridorLeavesOne) {
  expect_degenerate(corridor(), 1);
}
TEST(Degeneracy, ASphereLeavesItsRotations) {
  expect_degenerate(sphere({2, 0.5, 0.3}, 0.7), 3);
}
TEST(Degeneracy, ARoomLeavesNone) {
  const RegistrationResult r = register_to_itself(room(), Eigen::Isometry3d::Identity());
  EXPECT_TRUE(r.degenerate.empty());
  EXPECT_LT(r.covariance.diagonal().maxCoeff(), 0.01);
}

// In front of a bare wall the distance is measured and the rest is the prediction.
TEST(Degeneracy, TheWallsOwnDirectionsFollowThePrior) {
  Prior prior;
  prior.T_target_source = se3_exp(twist(0.03, 0.08, -0.05, 0.02, 0.01, -0.01));
  prior.information = Matrix6d::Identity() * 1e4;
  const RegistrationResult r = register_to_itself(wall(0.02), prior.T_target_source, &prior);
  ASSERT_TRUE(r.ok());
  const Eigen::Vector3d t = r.T_target_source.translation();
  EXPECT_NEAR(t.y(), 0.08, 0.01);
  EXPECT_NEAR(t.z(), -0.05, 0.01);
  EXPECT_NEAR((r.T_target_source * Eigen::Vector3d(2, 0, 0)).x(), 2, 0.002);
  const Vector6d sigma = r.covariance.diagonal().cwiseSqrt();
  EXPECT_LT(sigma(0), 0.005);
  EXPECT_NEAR(sigma(1), 0.01, 0.003);  // the prior's
}

TEST(Degeneracy, DirectionsHaveNames) {
  RegistrationResult result;
  result.degenerate = {twist(0, 0, 1, 0, 0, 0), twist(0.1, 0, 0, 0, 0, -0.9)};
  EXPECT_EQ(degenerate_names(result), (std::vector<std::string>{"z", "yaw"}));
}

// The corridor's own direction is named.
TEST(Degeneracy, ACorridorIsFreeAlongX) {
  const auto result = register_cloud(corridor(), KdTreeTarget(corridor()), Eigen::Isometry3d::Identity(), {});
  EXPECT_EQ(degenerate_names(result), std::vector<std::string>{"x"});
}

}  // namespace
}  // namespace lcmslam
