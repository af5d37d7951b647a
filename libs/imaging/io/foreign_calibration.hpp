#pragma once
// A camera's intrinsics as others write them: ROS's camera_info (the file of camera_calibration, or the
// message printed as YAML) and OpenCV's FileStorage (the file of its calibration programs).

#include <filesystem>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/imaging/camera_model.hpp>

namespace lcmslam {

/// A YAML file as a mapping. OpenCV's first line, "%YAML:1.0", is no YAML and is passed over.
ConfigNode load_calibration_yaml(const std::filesystem::path& file);

/// Whether the mapping holds a camera matrix under one of the names that ROS and OpenCV give it.
bool is_foreign_camera(const ConfigNode& config);

/// Image size, camera matrix and distortion; all other keys (calibration_time, projection_matrix ...) are
/// passed over. No distortion there: an ideal image. Throws ConfigError naming file, line and key: a key that
/// is missing, a matrix that is none, a lens model or a number of coefficients that CameraModel does not
/// know.
CameraModel read_foreign_camera(const ConfigNode& config);

/// ROS's camera_name; `otherwise` where there is none.
std::string foreign_camera_name(const ConfigNode& config, const std::string& otherwise);

}  // namespace lcmslam
