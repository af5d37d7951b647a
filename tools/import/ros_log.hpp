#pragma once
// A ROS recording as an .lcmlog that the graph replays.

#include <cstdint>
#include <functional>
#include <string>

#include <lcmslam/ros/ros_recording.hpp>

namespace lcmslam {

struct RosLogCounts {
  std::int64_t frames = 0, odometry = 0, truths = 0, bytes = 0;
};

/// CAMERA, CAMERA_CALIBRATION (first, then 1 Hz), odometry as POSE_BODY (bot_core's pose_t) or as TWIST, and
/// GROUND_TRUTH with message times. Throws std::runtime_error naming the file, also when no frame can be
/// read; then, and when `before_event` throws, nothing stays.
RosLogCounts write_ros_log(ros::RosRecording& recording, bool odometry_as_twist, const std::string& file,
                           const std::function<void()>& before_event = {});

}  // namespace lcmslam
