#pragma once
// Odometry from velocities: a base that reports (or is commanded) a twist instead of wheel angles.

#include <optional>

#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/odometry/wheel_noise.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

/// Velocity in the robot frame; holds until the next one.
struct Twist {
  Utime utime = 0;
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< rad/s
};

struct TwistOdometrySettings {
  WheelNoise noise;
  double curve_noise = 0;
  double delay = 0;
  double timeout = 1;
  double max_speed = 2;

  void describe(SettingsVisitor& s) {
    noise.describe(s);
    s.number("curve_noise", curve_noise, "m per root radian", {0, 1},
             "on each axis, by the angle turned: velocities of curves are not kept");
    s.number("delay", delay, "s", {-10, 10},
             "from a twist's stamp until the base moves so (commands, filters)");
    s.number("timeout", timeout, "s", {0, 3600},
             "that a twist holds without a successor, FEATURES telling that time goes on; then the base may "
             "do anything");
    s.number("max_speed", max_speed, "m/s and rad/s", {0, 100},
             "that the base may do when a twist has held for longer than timeout");
  }
};

class TwistOdometry {
 public:
  explicit TwistOdometry(const TwistOdometrySettings& settings = {});

  /// The pose T_odom_robot at twist.utime + delay, on exact arcs of the twist before; the identity at the
  /// first. A stamp that goes back starts anew; a repeated one gives nothing, nor does one that comes after
  /// hold() has told of a later time (what it changes is in the next pose).
  std::optional<MotionSample> update(const Twist& twist);

  /// The pose at a later time at which no other twist has come: a base may say once that it stands, and no
  /// more. Nothing where a twist may just be under way, if whoever waits for the pose is still there at
  /// `next`, when it is asked for again; and once timeout is so long past that nobody takes the motion since.
  std::optional<MotionSample> hold(Utime utime, Utime next);

  /// The twist that the base does at a time, as far as is known: none after timeout.
  std::optional<Twist> holding(Utime utime) const;

 private:
  double silence(Utime utime) const;
  MotionSample after(double seconds) const;

  TwistOdometrySettings settings_;
  std::optional<Twist> twist_;  // the one that holds
  MotionSample sample_;         // where it began
  Utime told_ = 0;              // the newest pose's
};

}  // namespace lcmslam
