#pragma once
// A log for `calibrate self`: images, and the motion that wheels or another driver tell beside them.

#include <memory>
#include <optional>
#include <string>

#include <lcmslam/calibration/self/recorded_scene.hpp>

namespace lcmslam {

struct RecordedHeadOptions {
  double rate = 0;     ///< Hz of the images, at most; 0: all
  double seconds = 0;  ///< of the log; 0: all
};

struct RecordedHead {
  RgbdCalibration start;
  std::unique_ptr<RecordedScene> scene;
  int damaged = 0;  ///< messages
};

/// Understood by `given`, else by the log's own calibration. Throws std::runtime_error without one, and
/// without images.
RecordedHead read_head(const std::string& log, const std::optional<RgbdCalibration>& given,
                       const RecordedHeadOptions& options);

}  // namespace lcmslam
