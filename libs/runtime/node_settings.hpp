#pragma once
// Settings that several nodes have.

#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

inline void describe_frame_queue(SettingsVisitor& s, int& frames) {
  s.number("frame_queue", frames, "", {1, 10000},
           "frames that may wait before the oldest is skipped: few keep answers fresh, many leave no gap in "
           "a replay");
}

inline void describe_max_wait(SettingsVisitor& s, double& seconds) {
  s.number(
      "max_wait", seconds, "s", {0, 10},
      "of message time that a frame waits for its odometry; then it goes on without, and that is counted");
}

/// How the robot moves: "auto", "planar" or "6dof".
inline void describe_pose(SettingsVisitor& s, std::string& pose) {
  s.choice("pose", pose, {"auto", "planar", "6dof"},
           "planar on the ground, or all six degrees of freedom; auto: planar where the camera has a mount");
}

}  // namespace lcmslam
