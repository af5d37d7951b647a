#pragma once
// Calibrations as files.

#include <filesystem>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam {

/// Reads the keys documented in config/calibration/tum_fr1.yaml; throws ConfigError naming file, line
/// and key. load_calibration also refuses keys that it does not know.
RgbdCalibration read_calibration(const ConfigNode& config);
RgbdCalibration load_calibration(const std::filesystem::path& file);

}  // namespace lcmslam
