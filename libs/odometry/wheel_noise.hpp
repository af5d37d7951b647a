#pragma once
// How wrong wheel odometry is. The errors are modelled as a random walk: variances grow in proportion
// to the way rolled and the angle turned, so that a covariance does not depend on how the way was cut
// into messages and increments are independent, as filters assume.
//
// A scale error is not a random walk: over the distance d it is k * d. It enters with the random walk
// that has the same size at `scale_length` (`scale_angle`): variance k^2 * scale_length * d. That
// overstates it on shorter ways and understates it on longer ones, which a map corrects.

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// Defaults are the errors of the simulated bases (2 and 3 % scale, 1 % and 0.5 degree of drift, a slip
/// of 2-5 cm and 1-3 degrees every 10 m).
struct WheelNoise {
  double longitudinal_scale = 0.02;  ///< standard deviation of the scale along x, ratio
  double lateral_scale = 0.03;       ///< along y
  double rotation_scale = 0.03;      ///< of the heading
  double scale_length = 1.0;         ///< m, see above
  double scale_angle = 1.0;          ///< rad

  double translation_drift = 0.01;  ///< m per root metre rolled, each axis
  double rotation_drift = 0.00873;  ///< rad per root metre rolled (0.5 degree)

  double slip_distance = 10;         ///< m rolled between slips
  double slip_translation = 0.0255;  ///< m, root mean square on each axis of one slip
  double slip_rotation = 0.0363;     ///< rad, root mean square of one slip (2.08 degrees)

  double flatness = 1e-3;          ///< m and rad per root metre: height, roll and pitch
  double rest_translation = 2e-4;  ///< m per root second on each axis, also at rest: quantisation
  double rest_rotation = 2e-4;     ///< rad per root second on each axis

  /// Throws std::invalid_argument that names the wrong value.
  void check() const;
};

/// Motion of the body during one increment, in its own frame.
struct PlanarIncrement {
  double x = 0, y = 0;    ///< m along the arc
  double heading = 0;     ///< rad
  double way_rolled = 0;  ///< m, mean way of the wheels' contacts: not 0 when turning on the spot
  double duration = 0;    ///< s

  Vector6d twist() const { return (Vector6d() << x, y, 0, 0, 0, heading).finished(); }
};

/// Covariance of one increment that is short enough to be straight (right perturbation): positive
/// definite when any of way and duration is above 0.
Matrix6d increment_covariance(const WheelNoise& noise, const PlanarIncrement& increment);

}  // namespace lcmslam
