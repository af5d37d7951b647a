#pragma once
// One least-squares estimator for every wheeled base. The body moves with (vx, vy, w); the contact of a
// wheel at (x, y) then moves with c = (vx - w y, vy + w x). In the wheel's frame (its x axis is the
// rolling direction, turned by the steering angle) c is (c_x, c_y), and
//   plain tyre:  radius * angle_rate = c_x   and   0 = c_y   (no side slip)
//   mecanum:     radius * angle_rate = c_x + c_y * tan(roller_angle), what goes along the roller's axis,
//   which
//                does not slip; across it the roller turns
// Differential, steered and mecanum bases differ only in their wheels.

#include <optional>
#include <vector>

#include <lcmslam/odometry/encoders.hpp>
#include <lcmslam/odometry/wheel_noise.hpp>

namespace lcmslam {

struct WheelFit {
  Eigen::Vector3d motion = Eigen::Vector3d::Zero();  ///< x, y (m), heading (rad) of the body
  double residual = 0;  ///< m, root mean square of the broken constraints: slip, wrong radii
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of `motion`, from the residual
  double way_rolled = 0;                                 ///< m, mean way of the contacts
};

/// Body motion between two readings of the same wheels, by constant body velocity: exact on arcs.
/// Steering is taken half-way (by the short way round). Throws std::invalid_argument when the wheels do
/// not determine the motion.
WheelFit fit_motion(const std::vector<Wheel>& before, const std::vector<Wheel>& after,
                    double side_slip_weight = 1.0);

/// Where plain tyres that roll along the body's x axis and did not steer keep the base from moving sideways:
/// the middle of their contacts, m; nothing where there are none.
std::optional<Eigen::Vector2d> held_sideways_at(const std::vector<Wheel>& before,
                                                const std::vector<Wheel>& after);

/// Throws std::invalid_argument that names the wheel and the value that is wrong.
void check_wheels(const std::vector<Wheel>& wheels);

}  // namespace lcmslam
