#pragma once
// A drive in a log, as the calibration of mount and wheels takes it.

#include <optional>
#include <string>

#include <lcmslam/calibration/drive_calibration.hpp>
#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam {

struct RecordedDrive {
  RgbdCalibration calibration;  ///< `given`, else the log's
  std::vector<MotionSample> camera;
  std::vector<WheelStep> steps;
  std::optional<FloorSight> floor;
  std::vector<Wheel> wheels;  ///< as the driver states them; empty: the log has ODOMETRY alone
  int images = 0, tracked = 0, damaged = 0;
  std::string first_damage;  ///< what was wrong with the first of them
};

/// The log's first calibration; its images may come before it.
std::optional<RgbdCalibration> calibration_in(const std::string& log);

/// Tracks the camera through a log's images, and reads ENCODERS or, where there are none, ODOMETRY.
/// Throws std::runtime_error where something lacks.
RecordedDrive read_drive(const std::string& log, const std::optional<RgbdCalibration>& given);

}  // namespace lcmslam
