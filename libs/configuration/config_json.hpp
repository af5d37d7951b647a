#pragma once
// A configuration as JSON, for records of runs.

#include <filesystem>
#include <string>

namespace lcmslam {

/// What the file says, with what it includes, on one line. Throws ConfigError as ConfigNode::load() does.
std::string config_json(const std::filesystem::path& file);

}  // namespace lcmslam
