#pragma once
// The gradient of an intensity along a surface, from a point's neighbours.

#include <Eigen/Dense>
#include <limits>

namespace lcmslam {

class TangentGradient {
 public:
  /// `normal`: unit, of the tangent plane.
  explicit TangentGradient(const Eigen::Vector3f& normal) {
    axes_.col(0) = normal.unitOrthogonal();
    axes_.col(1) = normal.cross(axes_.col(0));
  }

  /// A neighbour: where it lies from the point (m), and how much brighter it is.
  void add(const Eigen::Vector3f& offset, float difference) {
    const Eigen::Vector2f side = axes_.transpose() * offset;
    A_ += side * side.transpose();
    b_ += side * difference;
  }

  /// Least squares, 1/m; NaN where the neighbours lie on a line: unknown across it.
  Eigen::Vector3f solve() const {
    if (!(A_.determinant() > 1e-4f * A_.trace() * A_.trace()))
      return Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
    return axes_ * A_.ldlt().solve(b_);
  }

 private:
  Eigen::Matrix<float, 3, 2> axes_;
  Eigen::Matrix2f A_ = Eigen::Matrix2f::Zero();
  Eigen::Vector2f b_ = Eigen::Vector2f::Zero();
};

}  // namespace lcmslam
