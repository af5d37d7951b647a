#pragma once
// Odometry of a wheeled base: pose, covariance and twist from wheel encoders.

#include <optional>
#include <vector>

#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/odometry/encoders.hpp>
#include <lcmslam/odometry/wheel_noise.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct WheelOdometrySettings {
  WheelNoise noise;
  double side_slip_weight = 1.0;
  double max_wheel_speed = 10;
  std::vector<double> radius_factors;
  double layout_factor = 1;

  void describe(SettingsVisitor& s) {
    noise.describe(s);
    s.number("side_drift", noise.side_drift, "m per root metre", {0, 1},
             "random walk of the position across tyres that do not steer: they can but scrub");
    s.number("side_slip_weight", side_slip_weight, "", {1e-6, 1e6},
             "of a tyre's \"no side slip\" against its rolling");
    s.number("max_wheel_speed", max_wheel_speed, "m/s", {0.01, 1000},
             "at the rim; faster is a driver that restarted its counters");
    s.numbers("radius_factors", radius_factors, "", {0.5, 2},
              "true over stated radius of each wheel, as calibrate wheels finds them; empty: as stated");
    s.number("layout_factor", layout_factor, "", {0.5, 2},
             "true over stated places of the wheels (their track), as calibrate wheels finds it");
  }
};

/// Body velocity in the robot frame, mean over the last increment.
struct PlanarTwist {
  double vx = 0, vy = 0;  ///< m/s
  double w = 0;           ///< rad/s, counter-clockwise
};

class WheelOdometry {
 public:
  explicit WheelOdometry(const WheelOdometrySettings& settings = {});

  /// The first message gives the identity, later ones the pose T_odom_robot on exact arcs, with the
  /// covariance S_b = Ad(T_b_a) S_a Ad(T_b_a)^T + Q (right perturbation). Angles are cumulative: after
  /// lost messages the next one catches up.
  /// - A stamp that goes back starts anew at the identity; a repeated stamp gives nothing.
  /// - Another sender counts from another start, and wheels that turned impossibly far were reset, or that
  /// all
  ///   stand near zero after a silence: they give the old pose, its covariance with a slip and all that may
  ///   have been driven meanwhile (unknown_motion), and counting goes on from there (`restarts`).
  /// Throws std::invalid_argument, and stays as it was, when a wheel's value is wrong, when the number
  /// of wheels changed or when they do not determine the motion.
  std::optional<MotionSample> update(const Encoders& encoders);

  const PlanarTwist& twist() const { return twist_; }
  /// Root mean square of the broken rolling constraints over the last increment, m: slip.
  double residual() const { return residual_; }
  /// Times that the wheels' counters jumped.
  int restarts() const { return restarts_; }

 private:
  Encoders corrected(const Encoders& encoders) const;
  std::optional<MotionSample> step(const Encoders& encoders);
  void integrate(const PlanarIncrement& increment, const Eigen::Matrix3d& fit_covariance);
  void add_restart(Utime uncounted);
  void stand_still();
  void tell_twist(const Eigen::Vector3d& way, double seconds);

  WheelOdometrySettings settings_;
  std::vector<Wheel> wheels_;  // of the newest message; empty before the first
  std::int64_t sender_ = 0;    // likewise
  MotionSample sample_;
  PlanarTwist twist_;
  Eigen::Vector3d untold_way_ = Eigen::Vector3d::Zero();  // since it was told
  double untold_seconds_ = 0;
  double residual_ = 0;
  int restarts_ = 0;
};

}  // namespace lcmslam
