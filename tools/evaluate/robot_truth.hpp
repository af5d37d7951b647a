#pragma once
#include <string>

#include <lcmslam/evaluation/trajectory.hpp>

namespace lcmslam {

/// GROUND_TRUTH of a log as the robot's path: a camera's is moved by the log's calibration. Throws
/// std::runtime_error where there is none, or the camera's without a calibration.
Trajectory robot_truth(const std::string& log);

}  // namespace lcmslam
