#pragma once
// Writes a camera source as an .lcmlog that stock lcm-logplayer replays.

#include <string>

#include "camera/camera_source.hpp"

namespace lcmslam {

struct LogCounts {
  std::int64_t frames = 0, encoders = 0, truths = 0, bytes = 0;
};

/// CAMERA, CAMERA_CALIBRATION (first, then 1 Hz), ENCODERS and GROUND_TRUTH with message times. Writes to
/// FILE.part and renames at the end; throws std::runtime_error naming the file.
LogCounts write_log(CameraSource& source, const std::string& file);

}  // namespace lcmslam
