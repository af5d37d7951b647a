// The Jacobians of the map smoother's residuals against differences.

#include <lcmslam/fastslam/smoothing/map_factors.hpp>

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

Eigen::Isometry3d random_normal_pose(Random& random) {
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi(i) = random.normal();
  return se3_exp(xi);
}

// Central differences of a cost function's residuals by each of its parameters, at 0 or where they are given.
void expect_jacobians(const ceres::CostFunction& cost, std::vector<std::vector<double>> parameters,
                      double tolerance) {
  const int rows = cost.num_residuals();
  std::vector<std::vector<double>> analytic;
  std::vector<double*> blocks, jacobians;
  for (auto& block : parameters) {
    blocks.push_back(block.data());
    analytic.emplace_back(static_cast<std::size_t>(rows) * block.size());
  }
  for (auto& jacobian : analytic) jacobians.push_back(jacobian.data());
  std::vector<double> residual(static_cast<std::size_t>(rows)), plus = residual, minus = residual;
  ASSERT_TRUE(cost.Evaluate(blocks.data(), residual.data(), jacobians.data()));
  constexpr double h = 1e-6;
  for (std::size_t b = 0; b < parameters.size(); ++b)
    for (std::size_t c = 0; c < parameters[b].size(); ++c) {
      const double value = parameters[b][c];
      parameters[b][c] = value + h;
      cost.Evaluate(blocks.data(), plus.data(), nullptr);
      parameters[b][c] = value - h;
      cost.Evaluate(blocks.data(), minus.data(), nullptr);
      parameters[b][c] = value;
      for (std::size_t r = 0; r < plus.size(); ++r)
        EXPECT_NEAR(analytic[b][r * parameters[b].size() + c], (plus[r] - minus[r]) / (2 * h), tolerance)
            << "block " << b << ", row " << r << ", column " << c;
    }
}

TEST(MapFactors, JacobiansAreThoseOfDifferencesWhereTheMotionFits) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Eigen::Isometry3d A = random_normal_pose(random), B = random_normal_pose(random);
    const Matrix6d root = 3 * Matrix6d::Identity();
    const MotionError error(A, B, A.inverse() * B, root);
    expect_jacobians(error, {std::vector<double>(6, 0), std::vector<double>(6, 0)}, 1e-5);
  }
}

TEST(MapFactors, JacobiansOfObservationsAreThoseOfDifferences) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Eigen::Isometry3d T = random_normal_pose(random);
    Measurement z;
    z.value = Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    z.covariance.diagonal() << 0.04, 0.09, 0.25;
    const Eigen::Vector3d landmark = T * z.value + Eigen::Vector3d(0.1, -0.2, 0.3);
    expect_jacobians(ObservationError(T, z),
                     {std::vector<double>(6, 0), {landmark.x(), landmark.y(), landmark.z()}}, 1e-5);
  }
}

// L^-1 C L^-T = I in the free components.
TEST(MapFactors, RootInformationWhitensTheFreeComponents) {
  Random random(3);
  Matrix6d M;
  for (int i = 0; i < 36; ++i) M(i) = random.normal();
  const Matrix6d C = M * M.transpose() + Matrix6d::Identity();
  EXPECT_TRUE((free_root_information<6>(C) * C * free_root_information<6>(C).transpose())
                  .isApprox(Matrix6d::Identity(), 1e-9));
  const Matrix6d planar = free_root_information<3>(C) * C * free_root_information<3>(C).transpose();
  Matrix6d expected = Matrix6d::Zero();
  for (const int i : {0, 1, 5}) expected(i, i) = 1;
  EXPECT_TRUE(planar.isApprox(expected, 1e-9));
}

}  // namespace
}  // namespace lcmslam
