#pragma once
// evaluate --export: one channel of a log, or a text file in another format.

#include "tools/evaluate/trajectory_inputs.hpp"

namespace lcmslam {

/// Writes the one estimate's poses and says how many, whose and in which frame. As where paths are compared,
/// `estimate_body` stands above what the file says. Throws std::runtime_error where there are none.
void export_poses(const InputRequest& request, const std::string& file, bool kitti);

}  // namespace lcmslam
