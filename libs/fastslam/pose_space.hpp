#pragma once
// Which of the six components of a pose perturbation T * exp(xi) are free: three in the plane
// (x, y, heading), all six otherwise. Filters are written once for D = 3 and D = 6.

#include "geometry/transform.hpp"

namespace lcmslam {

template <int D>
struct PoseSpace {
  static_assert(D == 3 || D == 6);
  using Vector = Eigen::Matrix<double, D, 1>;
  using Matrix = Eigen::Matrix<double, D, D>;
  using Jacobian = Eigen::Matrix<double, 3, D>;

  /// Row of the twist (translation, rotation) that the free component is.
  static constexpr int row(int i) { return D == 6 ? i : (i == 2 ? 5 : i); }

  static Vector reduce(const Vector6d& twist) {
    Vector v;
    for (int i = 0; i < D; ++i) v(i) = twist(row(i));
    return v;
  }
  static Matrix reduce(const Matrix6d& covariance) {
    Matrix m;
    for (int i = 0; i < D; ++i)
      for (int j = 0; j < D; ++j) m(i, j) = covariance(row(i), row(j));
    return m;
  }
  static Vector6d expand(const Vector& v) {
    Vector6d twist = Vector6d::Zero();
    for (int i = 0; i < D; ++i) twist(row(i)) = v(i);
    return twist;
  }
  static Matrix6d expand(const Matrix& m) {
    Matrix6d covariance = Matrix6d::Zero();
    for (int i = 0; i < D; ++i)
      for (int j = 0; j < D; ++j) covariance(row(i), row(j)) = m(i, j);
    return covariance;
  }

  /// d residual / d xi at xi = 0 for residual = z - h, h = (T exp(xi))^-1 m, a point in the robot
  /// frame: [I, -hat(h)].
  static Jacobian residual_jacobian(const Eigen::Vector3d& h) {
    Jacobian J;
    if constexpr (D == 6) {
      J.template leftCols<3>().setIdentity();
      J.template rightCols<3>() = -hat(h);
    } else {
      J << 1, 0, -h.y(), 0, 1, h.x(), 0, 0, 0;
    }
    return J;
  }
};

/// The nearest pose of the space: in the plane (x, y, heading), otherwise the pose itself.
inline Eigen::Isometry3d restrict_pose(const Eigen::Isometry3d& T, bool planar) {
  return planar ? planar_pose(T.translation().x(), T.translation().y(), yaw(T)) : T;
}

}  // namespace lcmslam
