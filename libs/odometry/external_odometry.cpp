#include <lcmslam/odometry/external_odometry.hpp>

namespace lcmslam {
namespace {

constexpr double variance_per_metre = 4e-4;  // m^2 and rad^2: 2 cm and 1.1 degrees after the first metre
constexpr double turn_radius = 0.3;          // m that a radian of turning counts as
constexpr double resting_variance = 1e-8;    // m^2 and rad^2: no step is certain

}  // namespace

MotionSample ExternalOdometry::update(Utime utime, const Eigen::Isometry3d& T_odom_robot) {
  const Eigen::Isometry3d T_b_a = T_odom_robot.inverse() * sample_.T_odom_robot;
  const double way = T_b_a.translation().norm() + turn_radius * rotation_angle(T_b_a);
  const Matrix6d A = adjoint(T_b_a);
  sample_.covariance = (A * sample_.covariance * A.transpose() +
                        (resting_variance + variance_per_metre * way) * Matrix6d::Identity())
                           .eval();
  sample_.T_odom_robot = T_odom_robot;
  sample_.utime = utime;
  return sample_;
}

}  // namespace lcmslam
