#pragma once
// The wheels of a base and what their encoders read along a driven path, with the pinned errors.
//
// Convention for every wheel, with contact velocity v_c = (vx - w y, vy + w x) turned into the wheel's
// own frame (x along rolling): radius * d(angle)/dt = v_c.x + v_c.y tan(roller_angle); a plain tyre
// has v_c.y = 0 besides. Ideal kinematics on these readings gives wheel odometry with exactly the
// errors that were put in.

#include <string>
#include <vector>

#include <lcmslam/odometry/encoders.hpp>
#include <lcmslam/simulation/driven_path.hpp>

namespace lcmslam {

/// Pinned errors; "about" values are drawn for each run within `spread` of the magnitude, sign random.
struct WheelErrors {
  double translation_scale = 0.02;
  double lateral_scale = 0.03;
  double rotation_scale = 0.03;
  double spread = 0.25;                                            ///< relative
  double heading_drift = 0.0087266;                                ///< rad per root metre (0.5 degree)
  double position_drift = 0.01;                                    ///< m per root metre: 1 % over each metre
  double quantum = 0.001;                                          ///< m of wheel travel
  double slip_every = 10;                                          ///< m, on average
  double slip_low = 0.02, slip_high = 0.05;                        ///< m
  double slip_angle_low = 0.0174533, slip_angle_high = 0.0523599;  ///< rad (1..3 degrees)
  /// No errors at all but the quantum.
  static WheelErrors none();
};

/// Wheels at rest: "differential", "steered" (Care-O-bot 3: four steered wheels) or "mecanum".
/// Throws std::invalid_argument for another name.
std::vector<Wheel> make_wheels(const std::string& base);

/// All wheels that carry the base: besides those with encoders the casters of a differential one.
std::vector<CarryingWheel> carrying_wheels(const std::string& base);

/// Whether the base can drive sideways.
bool is_holonomic(const std::string& base);

/// Readings at 50 Hz from the path's start to its end; the first at `start`, all angles zero. Wheels measure
/// in the robot's own plane: on a ramp the way along its slope.
std::vector<Encoders> simulate_encoders(const DrivenPath& path, const std::string& base, Utime start,
                                        std::uint64_t seed, const WheelErrors& errors = {});

constexpr Utime encoder_period = 20'000;  ///< us

}  // namespace lcmslam
