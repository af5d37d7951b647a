#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include <lcmslam/fastslam/landmarks/small_cholesky.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

template <int N>
void expect_factor(std::uint64_t seed) {
  using Matrix = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;
  Random random(seed);
  Matrix B;
  Vector v;
  for (int i = 0; i < N * N; ++i) B(i) = random.normal();
  for (int i = 0; i < N; ++i) v(i) = random.normal();
  const Vector scales =
      Vector::NullaryExpr([&](Eigen::Index) { return std::pow(10., random.uniform(-3, 3)); });
  Matrix A = scales.asDiagonal() * (B * B.transpose() + 0.1 * Matrix::Identity()) * scales.asDiagonal();
  A = (0.5 * (A + A.transpose())).eval();  // metres and radians may differ in scale
  const double half_log_determinant = 0.5 * std::log(A.determinant());
  const SmallCholesky<N> root(A.template triangularView<Eigen::Lower>());
  const Vector x = root.solve(v);
  EXPECT_LT(((A * x - v).cwiseQuotient(scales)).norm(), 1e-9 * v.cwiseQuotient(scales).norm())
      << "seed " << seed;
  EXPECT_NEAR(root.half_log_determinant(), half_log_determinant, 1e-9) << "seed " << seed;
  // L^-T n of normal n has the covariance A^-1.
  Matrix product = Matrix::Zero();
  for (int i = 0; i < N; ++i) {
    const Vector column = root.solve_upper(Vector::Unit(i));
    product += column * column.transpose();
  }
  const Matrix identity = scales.asDiagonal().inverse() * (A * product) * scales.asDiagonal();
  EXPECT_TRUE(identity.isIdentity(1e-9)) << "seed " << seed;
}

TEST(SmallCholesky, SolvesAndMeasuresPositiveDefiniteMatrices) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    expect_factor<3>(seed);
    expect_factor<6>(seed);
  }
}

TEST(SmallCholesky, ShowsWhatIsNotPositiveDefinite) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Identity();
  A(1, 1) = -1;
  EXPECT_FALSE(SmallCholesky<3>(A).solve(Eigen::Vector3d::Ones()).allFinite());
}

}  // namespace
}  // namespace lcmslam
