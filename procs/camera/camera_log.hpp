#pragma once
// Camera data as an .lcmlog: written once, then played here or by stock lcm-logplayer.

#include <functional>
#include <string>

#include "procs/camera/camera_source.hpp"

namespace lcmslam {

struct LogCounts {
  std::int64_t frames = 0, encoders = 0, truths = 0, bytes = 0;
};

/// CAMERA, CAMERA_CALIBRATION (first, then 1 Hz), ENCODERS and GROUND_TRUTH with message times. The file is
/// there when it is whole. Throws std::runtime_error naming the file, also when the source gives no frame,
/// and what `before_event` throws; then nothing stays and an older file is as it was.
LogCounts write_log(CameraSource& source, const std::string& file,
                    const std::function<void()>& before_event = {});

/// Plays the same channels of a log; events of others are left out, damaged ones are counted as
/// malformed. Throws std::runtime_error when the file is missing, is no log, or has no calibration.
std::unique_ptr<CameraSource> open_log(const std::string& file);

}  // namespace lcmslam
