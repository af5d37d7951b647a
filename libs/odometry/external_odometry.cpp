#include <lcmslam/odometry/external_odometry.hpp>

#include <algorithm>

namespace lcmslam {
namespace {

constexpr double variance_per_metre = 4e-4;  // m^2 and rad^2: 2 cm and 1.1 degrees after the first metre
constexpr double turn_radius = 0.3;          // m that a radian of turning counts as
constexpr double resting_variance = 1e-8;    // m^2 and rad^2: no step is certain

double way_of(const Eigen::Isometry3d& T) {
  return T.translation().norm() + turn_radius * rotation_angle(T);
}

// Whether the driver that went `way` in these seconds, to where it says the robot is, has begun anew
// meanwhile.
bool begins_anew(double way, double seconds, const Eigen::Isometry3d& T_driver_robot) {
  constexpr double fastest = 10;             // m/s
  constexpr double shortest_step = 0.03;     // s: stamps of messages that came together tell no speed
  constexpr double shortest_silence = 0.3;   // s; a process starts no faster
  constexpr double away = 0.2, home = 0.02;  // m from the origin, and at it
  const bool restarts = seconds >= shortest_silence && way > away && way_of(T_driver_robot) < home;
  return restarts || way > fastest * std::max(seconds, shortest_step);
}

}  // namespace

MotionSample ExternalOdometry::update(Utime utime, const Eigen::Isometry3d& T_driver_robot) {
  const Eigen::Isometry3d T_b_a = (T_odom_driver_ * T_driver_robot).inverse() * sample_.T_odom_robot;
  const double way = way_of(T_b_a);
  const Utime elapsed = utime - sample_.utime;
  if (sample_.utime != 0 && elapsed > 0 &&
      begins_anew(way, 1e-6 * static_cast<double>(elapsed), T_driver_robot)) {
    T_odom_driver_ = sample_.T_odom_robot * T_driver_robot.inverse();
    sample_.covariance += unknown_motion(elapsed).covariance;
    ++restarts_;
  } else {
    const Matrix6d A = adjoint(T_b_a);
    sample_.covariance = (A * sample_.covariance * A.transpose() +
                          (resting_variance + variance_per_metre * way) * Matrix6d::Identity())
                             .eval();
    sample_.T_odom_robot = T_odom_driver_ * T_driver_robot;
  }
  sample_.utime = utime;
  return sample_;
}

}  // namespace lcmslam
