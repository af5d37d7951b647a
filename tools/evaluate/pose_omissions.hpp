#pragma once
// What of a log's poses is left out, a sentence each.

#include <string>
#include <vector>

#include "tools/evaluate/pose_log.hpp"

namespace lcmslam {

/// Of a whole log.
std::vector<std::string> omissions(const PoseLog& log, const std::string& file);
/// Of a channel, called "run.lcmlog:ICP_POSE".
std::vector<std::string> omissions(const PoseChannel& channel, const std::string& name);

}  // namespace lcmslam
