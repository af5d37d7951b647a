#pragma once
// Odometry from velocities: a base that reports (or is commanded) a twist instead of wheel angles.

#include <optional>

#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/odometry/wheel_noise.hpp>

namespace lcmslam {

/// Velocity in the robot frame; holds until the next one.
struct Twist {
  Utime utime = 0;
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< rad/s
};

struct TwistOdometrySettings {
  WheelNoise noise;
  double curve_noise = 0;  ///< m per root radian turned, each axis: velocities of curves are not kept
  double delay = 0;        ///< s from a twist's stamp until the base moves so (commands, filters)
  double timeout = 1;      ///< s that a twist holds without a successor; then the base may do anything
  double max_speed = 2;    ///< m/s and rad/s that it may do then

  void check() const;  ///< throws std::invalid_argument that names the wrong value
};

class TwistOdometry {
 public:
  explicit TwistOdometry(const TwistOdometrySettings& settings = {});

  /// The pose T_odom_robot at twist.utime + delay, on exact arcs of the twist before; the identity at the
  /// first. A stamp that goes back starts anew, a repeated one gives nothing.
  std::optional<MotionSample> update(const Twist& twist);

 private:
  void integrate(double seconds);

  TwistOdometrySettings settings_;
  std::optional<Twist> twist_;  // the one that holds
  MotionSample sample_;
};

}  // namespace lcmslam
