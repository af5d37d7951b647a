#pragma once
// New logs from old ones: `lcmslam log repair`, `lcmslam log cut` and `lcmslam log calibrate`.

#include <string>
#include <vector>

#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/log/log_reader.hpp>
#include "tools/log/log_selection.hpp"

namespace lcmslam {

struct LogEdit {
  std::int64_t read = 0;        ///< whole events of the input
  std::int64_t written = 0;     ///< events of the output
  std::int64_t joined = 0;      ///< messages of the output that were in pieces
  std::int64_t incomplete = 0;  ///< messages of the input that lack pieces
  std::vector<LogDamage> damages;
};

struct LogOutput {
  std::string file;
  bool overwrite = false;  ///< an existing file; never the input
};

/// Keeps every whole event. Throws std::runtime_error, and writes nothing, when the output exists, is the
/// input, nothing is whole, or a signal asks to stop.
LogEdit repair_log(const std::string& input, const LogOutput& output);

/// Keeps what is selected; the calibration that was valid there (the last CAMERA_CALIBRATION before)
/// comes first, with the log time of the first event. Damaged events are left out.
/// `robot`: of a log of several robots only this one's channels, and without its name.
LogEdit cut_log(const std::string& input, const LogOutput& output, const LogSelection& selection,
                const std::string& robot = "");

/// Puts a CAMERA_CALIBRATION before the first images_t and again every second, in the place of those that are
/// there. Throws std::runtime_error, and writes nothing, also when the log has no images, or none of the
/// calibration's sizes.
LogEdit calibrate_log(const std::string& input, const LogOutput& output, const RgbdCalibration& calibration);

}  // namespace lcmslam
