#pragma once
// Runs lcmslam evaluate on logs that are made for it.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/messages/parts.hpp>
#include "tests/unit/evaluation/path_samples.hpp"
#include "tests/unit/tools/mounted_camera.hpp"
#include "tests/unit/tools/scratch.hpp"
#include "tools/commands.hpp"
#include "tools/evaluate/evaluation_report.hpp"

namespace lcmslam::testing {

/// Writes messages with their own times.
class MessageLog {
 public:
  explicit MessageLog(const std::string& file) : log_(file) {}
  ~MessageLog() { log_.close(); }

  template <class M>
  void write(const std::string& channel, const M& message) {
    log_.write(message.utime, channel, encode_message(message));
  }
  /// In pieces, as where the kernel grants small buffers.
  template <class M>
  void write_in_pieces(const std::string& channel, const M& message) {
    for (part_t& part : split_message(channel, encode_message(message), message.utime, pieces_++, 500)) {
      part.seq = 0;
      part.sender = 5;
      log_.write(message.utime, part_channel(channel), encode_message(part));
    }
  }
  void write_bytes(const std::string& channel, Utime utime, const std::vector<std::uint8_t>& bytes) {
    log_.write(utime, channel, bytes);
  }

 private:
  LogWriter log_;
  std::int64_t pieces_ = 0;
};

inline ground_truth_t truth_message(const StampedPose& pose, const std::string& body) {
  ground_truth_t m;
  m.utime = pose.utime;
  m.seq = m.sender = 0;
  m.frame = "world";
  m.child_frame = body;
  m.T_frame_child = to_message(pose.T_world_body);
  return m;
}

inline pose_estimate_t estimate_message(const StampedPose& pose, std::int64_t sender = 5) {
  pose_estimate_t m = make_pose_estimate(pose.utime, pose.T_world_body, Matrix6d::Identity());
  m.seq = 0;
  m.sender = sender;
  return m;
}

inline odometry_t odometry_message(const StampedPose& pose, const std::string& source = "wheels") {
  MotionSample sample;
  sample.utime = pose.utime;
  sample.T_odom_robot = pose.T_world_body;
  sample.covariance = Matrix6d::Identity();
  odometry_t m = to_message(sample, source);
  m.seq = 0;
  m.sender = 5;
  return m;
}

class Evaluate : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (scratch_.path() / name).string(); }

  /// The command's exit code; its output is kept.
  int run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "evaluate");
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    int code = -1;
    try {
      code = evaluate_command(static_cast<int>(argv.size()), argv.data());
      output_.clear();
    } catch (const std::exception& error) {
      output_ = error.what();
    }
    output_ += ::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr();
    return code;
  }
  nlohmann::json json(const std::string& name) const { return nlohmann::json::parse(scratch_.read(name)); }
  static double ate(const nlohmann::json& result) {
    return result.at("ate").at("translation").at("rmse_m").get<double>();
  }
  /// The estimates that the inputs' reader finds, by the notes it makes.
  EvaluationInputs read(const std::string& truth, std::vector<std::string> estimates) const {
    return read_inputs({truth, std::move(estimates), "", "", ""});
  }

  /// A log with a truth of the camera, two mappers and odometry in worlds of their own.
  void write_log(const std::string& name, bool with_calibration = true) {
    MessageLog log(path(name));
    if (with_calibration) {
      camera_calibration_t c = to_message(mounted_camera());
      c.utime = c.seq = c.sender = 0;
      log.write("CAMERA_CALIBRATION", c);
    }
    Random random(3);
    for (const StampedPose& pose : path_) {
      StampedPose camera = pose;
      camera.T_world_body = pose.T_world_body * mounted_camera().T_robot_camera;
      log.write("GROUND_TRUTH", truth_message(camera, "camera"));
    }
    const Eigen::Isometry3d T_map_world = random_pose(random);
    for (const StampedPose& pose : moved(path_, T_map_world)) {
      log.write("ICP_POSE", estimate_message(pose));
      log.write("ODOMETRY", odometry_message(pose));
    }
    for (const StampedPose& pose : with_noise(path_, random, 0.02, 0))
      log.write("FASTSLAM_POSE", estimate_message(pose));
  }

  ScratchFolder scratch_;
  const Trajectory path_ = curved_path(200);
  std::string output_;
};

}  // namespace lcmslam::testing
