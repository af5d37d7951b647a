#pragma once
#include <string>

#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam {

/// A calibration as read_calibration() reads it: YAML, every number with all its digits. `comment` goes in
/// front, a
/// '#' before each of its lines.
std::string calibration_text(const RgbdCalibration& calibration, const std::string& comment = "");

}  // namespace lcmslam
