#pragma once
// Calibrations as files.

#include <filesystem>
#include <optional>
#include <string>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam {

/// Reads the keys documented in config/calibration/tum_fr1.yaml; throws ConfigError naming file, line
/// and key.
RgbdCalibration read_calibration(const ConfigNode& config);

/// The same from a file, keys that it does not know refused. A file of ROS or OpenCV
/// (foreign_calibration.hpp) is the colour camera of a head whose depth images are registered to its colour
/// images and that nobody mounted.
RgbdCalibration load_calibration(const std::filesystem::path& file);

/// One line for the user, who sees what was understood: sensor, image sizes, registered or not, mounted or
/// not.
std::string describe(const RgbdCalibration& calibration);

/// The calibration that stands under a sensor's name in `folder` (config/calibration), if there is one.
std::optional<RgbdCalibration> find_calibration(const std::string& sensor,
                                                const std::filesystem::path& folder);

}  // namespace lcmslam
