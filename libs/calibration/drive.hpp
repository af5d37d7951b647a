#pragma once
// A drive as calibration takes it: how the camera moved, what the wheels counted meanwhile, where the floor
// was.

#include <vector>

#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/odometry/encoders.hpp>

namespace lcmslam {

/// What the wheels say of one short step. The body's motion (x m, y m, heading rad, in its own frame) is
/// linear in the wheels' radii: a column for each wheel, as it is with the radii that the driver states.
struct WheelStep {
  Utime from = 0, to = 0;
  Eigen::Matrix<double, 3, Eigen::Dynamic> by_wheel;
  double way = 0;  ///< m
};

/// Steps of a log's ENCODERS; those of ODOMETRY have one column, all wheels together.
std::vector<WheelStep> wheel_steps(const std::vector<Encoders>& encoders);
std::vector<WheelStep> wheel_steps(const std::vector<MotionSample>& odometry);

/// The camera's motion over a stretch of the drive, and the wheels' steps in it.
struct Stretch {
  Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();  ///< colour camera
  Matrix6d covariance = Matrix6d::Identity();                   ///< T exp(xi), camera frame
  std::vector<WheelStep> steps;                                 ///< begun and ended with the stretch
};

struct StretchSettings {
  double turn = 0.35;    ///< rad, that end a stretch: the longer, the more the camera's own drift
  double way = 0.5;      ///< m, likewise
  double seconds = 3.0;  ///< longest; shorter ways in that time are left out
};

/// Cuts a drive into stretches. `camera` holds poses of the colour camera, in order of time, gaps where it
/// was not tracked (more than a second).
std::vector<Stretch> cut_drive(const std::vector<MotionSample>& camera, const std::vector<WheelStep>& steps,
                               const StretchSettings& settings = {});

}  // namespace lcmslam
