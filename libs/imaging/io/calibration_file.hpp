#pragma once
// Calibrations as files.

#include <filesystem>
#include <optional>
#include <string>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam {

/// Reads the keys documented in config/calibration/tum_fr1.yaml; throws ConfigError naming file, line
/// and key. load_calibration also refuses keys that it does not know.
RgbdCalibration read_calibration(const ConfigNode& config);
RgbdCalibration load_calibration(const std::filesystem::path& file);

/// The calibration that stands under a sensor's name in `folder` (config/calibration), if there is one.
std::optional<RgbdCalibration> find_calibration(const std::string& sensor,
                                                const std::filesystem::path& folder);

}  // namespace lcmslam
