#pragma once
// New logs from old ones: `lcmslam log repair` and `lcmslam log cut`.

#include <string>
#include <vector>

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
/// input, or nothing is whole.
LogEdit repair_log(const std::string& input, const LogOutput& output);

/// Keeps what is selected; the calibration that was valid there (the last CAMERA_CALIBRATION before)
/// comes first, with the log time of the first event. Damaged events are left out.
LogEdit cut_log(const std::string& input, const LogOutput& output, const LogSelection& selection);

}  // namespace lcmslam
