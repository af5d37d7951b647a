#pragma once
// Which options of `lcmslam import` mean something to which recording.

#include <string>

#include "tools/parse_command.hpp"

namespace lcmslam {

enum class RecordingKind { ros, mrclam, victoria_park, images };

/// The group of options for recordings of ROS alone.
inline const char* const ros_group = "ROS bags and MCAP files";

/// Throws std::invalid_argument for an option that was given and means nothing to the recording of this path.
void check_applicable(const CLI::App& app, RecordingKind kind, const std::string& path);

}  // namespace lcmslam
