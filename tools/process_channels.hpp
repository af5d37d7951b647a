#pragma once
// What the processes of a graph make, and of what: what of a log a graph computes itself.

#include <set>
#include <string>

namespace lcmslam {

/// Orders and questions, and what a process says of itself: told to those that run, and no measurement.
bool is_told(const std::string& channel);

/// False for processes that make nothing of what a log may hold.
bool makes(const std::string& process, const std::string& channel);

/// Of the log's channels those that these processes compute from it. A process that finds nothing to work on
/// there computes nothing: where a log has FEATURES without images, surf does not make them.
std::set<std::string> computed_channels(const std::set<std::string>& in_log,
                                        const std::set<std::string>& processes);

}  // namespace lcmslam
