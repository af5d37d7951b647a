#pragma once
// 3x3 symmetric matrices, written out: half the work of general products, and symmetric to the last bit.

#include <Eigen/Core>

namespace lcmslam {

/// A B A^T for symmetric B.
inline Eigen::Matrix3d sandwiched(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
  const Eigen::Matrix3d AB = A * B;
  Eigen::Matrix3d C;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j)
      C(i, j) = C(j, i) = AB(i, 0) * A(j, 0) + AB(i, 1) * A(j, 1) + AB(i, 2) * A(j, 2);
  return C;
}

/// A B where the product is known to be symmetric: its lower triangle, mirrored.
inline Eigen::Matrix3d symmetric_product(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
  Eigen::Matrix3d C;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j)
      C(i, j) = C(j, i) = A(i, 0) * B(0, j) + A(i, 1) * B(1, j) + A(i, 2) * B(2, j);
  return C;
}

struct SymmetricInverse {
  Eigen::Matrix3d inverse;
  double determinant;
};

/// By cofactors. A singular matrix gives what division by zero gives.
inline SymmetricInverse invert_symmetric(const Eigen::Matrix3d& S) {
  const double a = S(0, 0), b = S(1, 0), c = S(2, 0), d = S(1, 1), e = S(2, 1), f = S(2, 2);
  const double A = d * f - e * e, B = c * e - b * f, C = b * e - c * d;
  const double determinant = a * A + b * B + c * C;
  const double scale = 1 / determinant;
  const double D = a * f - c * c, E = b * c - a * e, F = a * d - b * b;
  SymmetricInverse result;
  result.inverse << A, B, C, B, D, E, C, E, F;
  result.inverse *= scale;
  result.determinant = determinant;
  return result;
}

}  // namespace lcmslam
