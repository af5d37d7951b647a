#pragma once
// How wrong wheel odometry is. The errors are modelled as a random walk: variances grow in proportion
// to the way rolled and the angle turned, so that a covariance does not depend on how the way was cut
// into messages and increments are independent, as filters assume.
//
// A scale error is not a random walk: over the distance d it is k * d. It enters with the random walk
// that has the same size at `scale_length` (`scale_angle`): variance k^2 * scale_length * d. That
// overstates it on shorter ways and understates it on longer ones, which a map corrects.

#include <optional>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

/// Defaults are the errors of the simulated bases (2 and 3 % scale, 1 % and 0.5 degree of drift, a slip
/// of 2-5 cm and 1-3 degrees every 10 m).
struct WheelNoise {
  double longitudinal_scale = 0.02;
  double lateral_scale = 0.03;
  double rotation_scale = 0.03;
  double scale_length = 1.0;
  double scale_angle = 1.0;

  double translation_drift = 0.01;
  double side_drift = 0.002;  ///< of a base held sideways; its key is that of wheels, whose places tell it
  double rotation_drift = 0.00873;

  double slip_distance = 10;
  double slip_translation = 0.0255;
  double slip_rotation = 0.0363;

  double flatness = 1e-3;
  double rest_translation = 2e-4;
  double rest_rotation = 2e-4;

  void describe(SettingsVisitor& s) {
    s.number("longitudinal_scale", longitudinal_scale, "", {0, 1},
             "standard deviation of the scale along x, ratio");
    s.number("lateral_scale", lateral_scale, "", {0, 1}, "standard deviation of the scale along y, ratio");
    s.number("rotation_scale", rotation_scale, "", {0, 1},
             "standard deviation of the heading's scale, ratio");
    s.number("scale_length", scale_length, "m", {0, 1000},
             "way at which the random walk is as large as the scale's error");
    s.number("scale_angle", scale_angle, "rad", {0, 1000},
             "turn at which the random walk is as large as the scale's error");
    s.number("translation_drift", translation_drift, "m per root metre", {0, 1},
             "random walk of the position on each axis, by the way rolled");
    s.number("rotation_drift", rotation_drift, "rad per root metre", {0, 1},
             "random walk of the heading, by the way rolled (0.00873: half a degree)");
    s.number("slip_distance", slip_distance, "m", {1e-3, 1e9}, "rolled between slips");
    s.number("slip_translation", slip_translation, "m", {0, 1}, "root mean square on each axis of one slip");
    s.number("slip_rotation", slip_rotation, "rad", {0, 1}, "root mean square of one slip");
    s.number("flatness", flatness, "m and rad per root metre", {1e-9, 1},
             "height, roll and pitch of the ground");
    s.number("rest_translation", rest_translation, "m per root second", {1e-9, 1},
             "on each axis, also at rest: quantisation");
    s.number("rest_rotation", rest_rotation, "rad per root second", {1e-9, 1},
             "on each axis, also at rest: quantisation");
  }
};

/// Motion of the body during one increment, in its own frame.
struct PlanarIncrement {
  double x = 0, y = 0;    ///< m along the arc
  double heading = 0;     ///< rad
  double way_rolled = 0;  ///< m, mean way of the wheels' contacts: not 0 when turning on the spot
  double duration = 0;    ///< s
  /// m, in the body's frame: where tyres that do not steer hold the base from moving sideways.
  std::optional<Eigen::Vector2d> held_at = std::nullopt;

  Vector6d twist() const { return (Vector6d() << x, y, 0, 0, 0, heading).finished(); }
};

/// Covariance of one increment that is short enough to be straight (right perturbation): positive
/// definite when any of way and duration is above 0.
Matrix6d increment_covariance(const WheelNoise& noise, const PlanarIncrement& increment);

}  // namespace lcmslam
