#pragma once
// Rigid transforms. T_dst_src maps coordinates of frame src to frame dst: p_dst = T_dst_src * p_src.
//
// Twists and pose errors are 6-vectors (translation, rotation), in metres and radians. A pose
// T with covariance S means T * exp(xi), xi ~ N(0, S): the error stands in the body frame (right
// perturbation).

#include <Eigen/Geometry>
#include <cstdint>

namespace lcmslam {

/// Microseconds since the epoch at which a sensor measured.
using Utime = std::int64_t;

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Skew-symmetric matrix: hat(a) * b = a x b.
Eigen::Matrix3d hat(const Eigen::Vector3d& v);

/// Exponential and logarithm of SO(3), rotation vector in radians (norm below pi).
Eigen::Matrix3d so3_exp(const Eigen::Vector3d& rotation);
Eigen::Vector3d so3_log(const Eigen::Matrix3d& rotation);

/// Exponential and logarithm of SE(3), twist = (translation, rotation).
Eigen::Isometry3d se3_exp(const Vector6d& twist);
Vector6d se3_log(const Eigen::Isometry3d& transform);

/// Ad(T): T * exp(xi) = exp(Ad(T) xi) * T.
Matrix6d adjoint(const Eigen::Isometry3d& transform);

/// Constant-velocity interpolation, fraction 0 gives a, 1 gives b; extrapolates outside.
Eigen::Isometry3d interpolate(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double fraction);

/// Angle of the rotation in radians, 0..pi.
double rotation_angle(const Eigen::Isometry3d& transform);

/// Between two poses in one frame: m, and rad of the rotation from one to the other.
double distance_between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);
double angle_between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

/// Heading (rotation about world z) in radians.
double yaw(const Eigen::Isometry3d& T_world_robot);

/// Pose in the plane: (x, y) in metres, heading in radians.
Eigen::Isometry3d planar_pose(double x, double y, double heading);

/// From a unit quaternion in the wire's order (w, x, y, z).
Eigen::Isometry3d make_transform(const double translation[3], const double quaternion_wxyz[4]);

/// Camera axes (x right, y down, z forward) expressed in robot axes (x forward, y left, z up).
Eigen::Isometry3d optical_axes();

}  // namespace lcmslam
