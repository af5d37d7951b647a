#pragma once
// Whether a log's images fit its calibration (rgbd/plausibility.hpp): what is well formed may be wrong all
// the same.

#include <string>
#include <vector>

namespace lcmslam {

struct LogPlausibility {
  int frames = 0;                     ///< that were looked at, spread over the log
  std::string depths;                 ///< the depth images in words; empty without frames
  std::vector<std::string> findings;  ///< what looks wrong, and what would be right
};

/// Looks at a dozen frames of CAMERA, by the last CAMERA_CALIBRATION before them. A log without both has no
/// findings. Throws std::runtime_error when the file is no log.
LogPlausibility plausibility_of_log(const std::string& file);

/// One line a finding, each below the last: "  looks wrong: ...", and the depths in words before them.
std::string format_plausibility(const LogPlausibility& plausibility);

}  // namespace lcmslam
