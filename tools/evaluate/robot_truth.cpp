#include "tools/evaluate/robot_truth.hpp"

#include <stdexcept>

#include "tools/evaluate/pose_log.hpp"

namespace lcmslam {

Trajectory robot_truth(const std::string& log) {
  const PoseLog poses = read_pose_log(log);
  const PoseChannel& truth = poses.channel("GROUND_TRUTH", log);
  if (truth.body != "camera") return truth.trajectory;
  if (!poses.calibration()) throw std::runtime_error(log + ": its truth is the camera's, and no calibration");
  return in_other_frame(truth.trajectory, poses.calibration()->T_robot_camera.inverse());
}

}  // namespace lcmslam
