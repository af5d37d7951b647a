#pragma once
// Whose poses a topic of true poses tells: a motion capture's markers, a camera or the robot.

#include <string>

#include <lcmslam/ros/transform_tree.hpp>

namespace lcmslam::ros {

struct TruthBody {
  std::string body = "robot";                                     ///< or "camera": the colour camera
  Eigen::Isometry3d T_told_body = Eigen::Isometry3d::Identity();  ///< the body in the frame that was told
  std::string note;  ///< what was converted or assumed; empty: nothing
};

/// `frame`: the poses' child_frame_id, empty where they have none; `robot_frame`: empty where nobody knows
/// it. By tf only what sits still on the robot or the camera is brought there.
TruthBody find_truth_body(const std::string& frame, const std::string& robot_frame,
                          const std::string& colour_frame, const TransformTree& transforms);

}  // namespace lcmslam::ros
