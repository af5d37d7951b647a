#include "tools/import/ros_log.hpp"

#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/runtime/log_publisher.hpp>

namespace lcmslam {
namespace {

constexpr Utime calibration_period = 1'000'000;  // us

/// The velocities are in the robot's frame in both.
pose_t pose_message(const ros::OdometryEvent& odometry) {
  pose_t message{};
  message.utime = odometry.utime;
  const rigid_transform_t T = to_message(odometry.T_odom_robot);
  for (int i = 0; i < 3; ++i) {
    message.pos[i] = T.trans[i];
    message.vel[i] = odometry.twist.linear(i);
    message.rotation_rate[i] = odometry.twist.angular(i);
  }
  for (int i = 0; i < 4; ++i) message.orientation[i] = T.quat[i];
  return message;
}

ground_truth_t truth_message(const ros::TruthEvent& truth) {
  ground_truth_t message;
  message.utime = truth.utime;
  message.frame = "world";
  message.child_frame = truth.body;
  message.T_frame_child = to_message(truth.T_world_body);
  return message;
}

class RosLogWriter {
 public:
  RosLogWriter(const RgbdCalibration& calibration, bool odometry_as_twist, LogPublisher& log)
      : calibration_(to_message(calibration)), odometry_as_twist_(odometry_as_twist), log_(log) {}

  void operator()(const EncodedFrame& frame) {
    if (frame.utime >= next_calibration_) {
      calibration_.utime = frame.utime;
      log_.publish("CAMERA_CALIBRATION", calibration_);
      next_calibration_ = frame.utime + calibration_period;
    }
    log_.publish("CAMERA", to_message(frame));
    ++counts.frames;
  }
  void operator()(const ros::OdometryEvent& odometry) {
    if (odometry_as_twist_)
      log_.publish("TWIST", to_message(odometry.twist));
    else
      log_.publish("POSE_BODY", pose_message(odometry));
    ++counts.odometry;
  }
  void operator()(const ros::TruthEvent& truth) {
    log_.publish("GROUND_TRUTH", truth_message(truth));
    ++counts.truths;
  }

  RosLogCounts counts;

 private:
  camera_calibration_t calibration_;
  bool odometry_as_twist_;
  LogPublisher& log_;
  Utime next_calibration_ = 0;
};

}  // namespace

RosLogCounts write_ros_log(ros::RosRecording& recording, bool odometry_as_twist, const std::string& file,
                           const std::function<void()>& before_event) {
  LogPublisher log(file);
  RosLogWriter writer(recording.calibration(), odometry_as_twist, log);
  while (const auto event = recording.next()) {
    if (before_event) before_event();
    std::visit(writer, *event);
  }
  if (writer.counts.frames == 0) {
    const auto problems = recording.problems();
    throw std::runtime_error(file + ": is not written, no frame could be read" +
                             (problems.empty() ? "" : ": " + problems.front()));
  }
  writer.counts.bytes = log.bytes();
  log.close();
  return writer.counts;
}

}  // namespace lcmslam
