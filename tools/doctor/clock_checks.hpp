#pragma once
// Whether odometry and camera are stamped by one clock, from the motion itself
// (lcmslam/odometry/odometry_clock.hpp), and the setting that makes it so.

#include <string>

#include "tools/doctor/checks.hpp"

namespace lcmslam {

/// Of a log with images (or FEATURES) and ENCODERS, TWIST, POSE_BODY or ODOMETRY, the first of these that is
/// there. Throws std::runtime_error when the file is no log.
Finding check_odometry_clock(const std::string& log);

/// Of a graph that runs and drives meanwhile: listens to its FEATURES and ODOMETRY.
Finding check_odometry_clock_live(const std::string& lcm_url, double seconds);

}  // namespace lcmslam
