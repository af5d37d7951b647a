#include <lcmslam/geometry/transform.hpp>

#include <cmath>

namespace lcmslam {
namespace {

// V v with the left Jacobian of SO(3), V = I + b W + c W^2, W = hat(rotation): translation part of the SE(3)
// exponential.
Eigen::Vector3d left_jacobian_times(const Eigen::Vector3d& rotation, const Eigen::Vector3d& v) {
  const double angle2 = rotation.squaredNorm();
  double b = 0.5 - angle2 / 24;
  double c = 1.0 / 6.0 - angle2 / 120;
  if (angle2 > 1e-8) {
    const double angle = std::sqrt(angle2);
    const double sine = std::sin(0.5 * angle), cosine = std::cos(0.5 * angle);
    b = 2 * sine * sine / angle2;
    c = (angle - 2 * sine * cosine) / (angle * angle2);
  }
  const Eigen::Vector3d Wv = rotation.cross(v);
  return v + b * Wv + c * rotation.cross(Wv);
}

// V^-1 v, V^-1 = I - W / 2 + d W^2, d = (1 - (angle / 2) cot(angle / 2)) / angle^2 (Sola, Deray & Atchuthan
// 2018, "A micro Lie theory", eq. 146); angle in [0, pi].
Eigen::Vector3d left_jacobian_inverse_times(const Eigen::Vector3d& rotation, const Eigen::Vector3d& v) {
  const double angle2 = rotation.squaredNorm();
  double d = 1.0 / 12.0 + angle2 / 720;
  if (angle2 > 1e-4) {
    const double half = 0.5 * std::sqrt(angle2);
    d = (1 - half * std::cos(half) / std::sin(half)) / angle2;
  }
  const Eigen::Vector3d Wv = rotation.cross(v);
  return v - 0.5 * Wv + d * rotation.cross(Wv);
}

}  // namespace

Eigen::Matrix3d hat(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d so3_exp(const Eigen::Vector3d& rotation) {
  const double angle = rotation.norm();
  Eigen::Quaterniond q;
  const double half = 0.5 * angle;
  const double scale = angle > 1e-8 ? std::sin(half) / angle : 0.5;
  q.w() = std::cos(half);
  q.vec() = scale * rotation;
  return q.normalized().toRotationMatrix();
}

Eigen::Vector3d so3_log(const Eigen::Matrix3d& rotation) {
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (sine < 1e-12) return 2.0 * q.vec();
  return (2.0 * std::atan2(sine, q.w()) / sine) * q.vec();
}

Eigen::Isometry3d se3_exp(const Vector6d& twist) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = so3_exp(twist.tail<3>());
  T.translation() = left_jacobian_times(twist.tail<3>(), twist.head<3>());
  return T;
}

Vector6d se3_log(const Eigen::Isometry3d& transform) {
  Vector6d twist;
  twist.tail<3>() = so3_log(transform.linear());
  twist.head<3>() = left_jacobian_inverse_times(twist.tail<3>(), transform.translation());
  return twist;
}

Matrix6d adjoint(const Eigen::Isometry3d& transform) {
  Matrix6d A = Matrix6d::Zero();
  A.topLeftCorner<3, 3>() = transform.linear();
  A.bottomRightCorner<3, 3>() = transform.linear();
  A.topRightCorner<3, 3>() = hat(transform.translation()) * transform.linear();
  return A;
}

Eigen::Isometry3d interpolate(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double fraction) {
  return a * se3_exp(fraction * se3_log(a.inverse() * b));
}

double rotation_angle(const Eigen::Isometry3d& transform) {
  return so3_log(transform.linear()).norm();
}

double distance_between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.translation() - b.translation()).norm();
}

double angle_between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return rotation_angle(a.inverse() * b);
}

double yaw(const Eigen::Isometry3d& T_world_robot) {
  return std::atan2(T_world_robot(1, 0), T_world_robot(0, 0));
}

Eigen::Isometry3d planar_pose(double x, double y, double heading) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() << x, y, 0;
  return T;
}

Eigen::Isometry3d make_transform(const double translation[3], const double quaternion_wxyz[4]) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() =
      Eigen::Quaterniond(quaternion_wxyz[0], quaternion_wxyz[1], quaternion_wxyz[2], quaternion_wxyz[3])
          .normalized()
          .toRotationMatrix();
  T.translation() << translation[0], translation[1], translation[2];
  return T;
}

Eigen::Isometry3d optical_axes() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return T;
}

}  // namespace lcmslam
