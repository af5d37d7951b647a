#pragma once
// Exact wheel motions of the three kinds of base, from the constraint equations (wheel_kinematics.hpp).

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include <lcmslam/odometry/encoders.hpp>
#include <lcmslam/odometry/wheel_odometry.hpp>

namespace lcmslam::testing {

struct Base {
  std::string name;
  Encoders encoders;
  bool steered = false;   ///< wheels turn into the direction of motion
  bool sideways = false;  ///< can move along y
};

inline Wheel make_wheel(double x, double y, double radius, double roller_angle = 0) {
  Wheel wheel;
  wheel.x = x;
  wheel.y = y;
  wheel.radius = radius;
  wheel.roller_angle = roller_angle;
  return wheel;
}

inline Base differential_base() {
  return {
      "differential", {1'000'000, 0, 0, {make_wheel(0, 0.2, 0.1), make_wheel(0, -0.2, 0.1)}}, false, false};
}

inline Base steered_base() {
  Base base{"steered", {1'000'000, 0, 0, {}}, true, true};
  for (const double x : {0.25, -0.25}) {
    for (const double y : {0.2, -0.2}) base.encoders.wheels.push_back(make_wheel(x, y, 0.08));
  }
  return base;
}

inline Base mecanum_base() {
  Base base{"mecanum", {1'000'000, 0, 0, {}}, false, true};
  const double angle = M_PI / 4;  // X arrangement: rollers of diagonal wheels alike
  base.encoders.wheels = {make_wheel(0.3, 0.25, 0.076, -angle), make_wheel(0.3, -0.25, 0.076, angle),
                          make_wheel(-0.3, 0.25, 0.076, angle), make_wheel(-0.3, -0.25, 0.076, -angle)};
  return base;
}

inline std::vector<Base> all_bases() {
  return {differential_base(), steered_base(), mecanum_base()};
}

/// Turns the steering towards the motion, as a base does before it sets off.
inline void steer(Base& base, const PlanarTwist& twist) {
  if (!base.steered) return;
  for (Wheel& wheel : base.encoders.wheels) {
    const double cx = twist.vx - twist.w * wheel.y, cy = twist.vy + twist.w * wheel.x;
    if (std::hypot(cx, cy) > 1e-9) wheel.steering = std::atan2(cy, cx);
  }
}

/// Turns the wheels as the motion demands, for whole microseconds.
inline void drive(Base& base, const PlanarTwist& twist, double about_seconds) {
  const double seconds = 1e-6 * std::round(about_seconds * 1e6);
  steer(base, twist);
  for (Wheel& wheel : base.encoders.wheels) {
    const double cx = twist.vx - twist.w * wheel.y, cy = twist.vy + twist.w * wheel.x;
    const double c = std::cos(wheel.steering), s = std::sin(wheel.steering);
    const double rolling = c * cx + s * cy, side = -s * cx + c * cy;
    wheel.angle += (rolling + side * std::tan(wheel.roller_angle)) * seconds / wheel.radius;
  }
  base.encoders.utime += std::llround(seconds * 1e6);
  ++base.encoders.seq;
}

inline void expect_near(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double tolerance,
                        const std::string& what) {
  EXPECT_LT((a.matrix() - b.matrix()).cwiseAbs().maxCoeff(), tolerance) << what;
}

inline Eigen::Isometry3d arc(const PlanarTwist& twist, double seconds) {
  Vector6d xi;
  xi << twist.vx, twist.vy, 0, 0, 0, twist.w;
  return se3_exp(seconds * xi);
}

}  // namespace lcmslam::testing
