#pragma once
// Which of the six components of a pose perturbation T * exp(xi) are free: three in the plane
// (x, y, heading), all six otherwise. Filters are written once for D = 3 and D = 6.

#include <lcmslam/geometry/transform.hpp>

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

  /// J^T W J with J = residual_jacobian(h), for symmetric W (3x3): its blocks written out,
  ///   [W, -W hat(h); hat(h) W, -hat(h) W hat(h)].
  static Matrix normal_matrix(const Eigen::Matrix3d& W, const Eigen::Vector3d& h) {
    Matrix N;
    if constexpr (D == 6) {
      Eigen::Matrix3d B;  // hat(h) W: its columns are h x (column of W)
      for (int i = 0; i < 3; ++i) B.col(i) = h.cross(W.col(i));
      N.template topLeftCorner<3, 3>() = W;
      N.template bottomLeftCorner<3, 3>() = B;
      N.template topRightCorner<3, 3>() = B.transpose();
      for (int i = 0; i < 3; ++i)  // hat(h) (hat(h) W)^T
        N.template bottomRightCorner<3, 3>().col(i) = h.cross(B.row(i).transpose());
    } else {
      const double x = W(0, 1) * h.x() - W(0, 0) * h.y(), y = W(1, 1) * h.x() - W(1, 0) * h.y();
      N << W(0, 0), W(0, 1), x, W(1, 0), W(1, 1), y, x, y, h.x() * y - h.y() * x;
    }
    return N;
  }
  /// J^T g: the force g at h and its torque h x g.
  static Vector wrench(const Eigen::Vector3d& g, const Eigen::Vector3d& h) {
    Vector w;
    if constexpr (D == 6)
      w << g, h.cross(g);
    else
      w << g.x(), g.y(), h.x() * g.y() - h.y() * g.x();
    return w;
  }
};

/// The nearest pose of the space: in the plane (x, y, heading), otherwise the pose itself.
inline Eigen::Isometry3d restrict_pose(const Eigen::Isometry3d& T, bool planar) {
  return planar ? planar_pose(T.translation().x(), T.translation().y(), yaw(T)) : T;
}

/// The same pose with an exact rotation: products of many drift off the group.
inline Eigen::Isometry3d renormalised(Eigen::Isometry3d T, bool planar) {
  T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  return restrict_pose(T, planar);
}

}  // namespace lcmslam
