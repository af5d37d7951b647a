#include "tools/demo/run_recorder.hpp"

#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t most_poses = 200'000;          // two hours at 30 Hz, some 90 MB a path
constexpr std::size_t most_truths = 4 * most_poses;  // they come more often

}  // namespace

void ThinnedPath::add(const StampedPose& pose, std::size_t most) {
  if (heard++ % every == 0) trajectory.push_back(pose);
  if (trajectory.size() < most) return;
  for (std::size_t i = 0; 2 * i < trajectory.size(); ++i) trajectory[i] = trajectory[2 * i];
  trajectory.resize((trajectory.size() + 1) / 2);
  every *= 2;
}

RunRecorder::RunRecorder(Inputs& inputs) {
  inputs.subscribe<status_t>("STATUS", 1000, [this](const status_t& m) { board_[m.process] = m; });
  inputs.subscribe<camera_calibration_t>("CAMERA_CALIBRATION", 10, [this](const camera_calibration_t& m) {
    calibration_ = from_message(m);
    calibration_message_ = m;
  });
  inputs.subscribe<ground_truth_t>("GROUND_TRUTH", 10000, [this](const ground_truth_t& m) {
    truth_frame_ = m.child_frame;
    truth_.add({m.utime, from_message(m.T_frame_child, "T_frame_child")}, most_truths);
  });
  inputs.subscribe<odometry_t>("ODOMETRY", 10000, [this](const odometry_t& m) {
    add(odometry_, m.utime, m.sender, m.status, from_message(m).T_odom_robot);
  });
  inputs.subscribe<pose_estimate_t>("FASTSLAM_POSE", 10000, [this](const pose_estimate_t& m) {
    add(fastslam_, m.utime, m.sender, m.status, from_message(m.T_map_robot, "T_map_robot"), m.map_revision);
  });
  inputs.subscribe<pose_estimate_t>("ICP_POSE", 10000, [this](const pose_estimate_t& m) {
    add(icp_, m.utime, m.sender, m.status, from_message(m.T_map_robot, "T_map_robot"), m.map_revision);
  });
  inputs.subscribe<map_reply_t>("MAP_REPLY", 100, [this](const map_reply_t& m) { reply_ = m; });
}

void RunRecorder::add(RecordedPath& path, Utime utime, std::int64_t sender, std::int8_t status,
                      const Eigen::Isometry3d& pose, std::int64_t map_revision) {
  const bool restarted = (path.sender != 0 && path.sender != sender) || map_revision < path.map_revision;
  const bool rewound = !path.trajectory.empty() && utime < path.trajectory.back().utime - 1'000'000;
  if (restarted || rewound) {  // another map, another frame: earlier poses do not compare
    path.trajectory.clear();
    path.every = 1;
    path.heard = 0;
    ++path.restarts;
  }
  path.sender = sender;
  path.map_revision = map_revision;
  ++messages_;
  path.add({utime, pose}, most_poses);
  path.lost += status == pose_estimate_t::LOST ? 1 : 0;
  path.degraded += status == pose_estimate_t::DEGRADED ? 1 : 0;
}

// Another body's path taken for the robot's gives errors that nobody made.
std::string RunRecorder::truth_problem() const {
  if (truth_.trajectory.empty() || truth_frame_ == "robot" || truth_frame_.empty()) return "";
  if (truth_frame_ != "camera")
    return "the truth is that of '" + truth_frame_ + "', which nobody places on the robot: not compared with";
  return calibration_
             ? ""
             : "the truth is the camera's, and no CAMERA_CALIBRATION says where that is: not compared with";
}

Trajectory RunRecorder::truth() const {
  if (!truth_problem().empty()) return {};
  Trajectory truth = truth_.trajectory;
  sort_trajectory(truth);
  if (truth_frame_ != "camera") return truth;
  return in_other_frame(truth, calibration_->T_robot_camera.inverse());
}

std::optional<TrajectoryReport> RunRecorder::evaluate_path(const RecordedPath& path, std::string* why) const {
  if (truth_.trajectory.size() < 2 || path.trajectory.size() < 3 || !truth_problem().empty())
    return std::nullopt;
  Trajectory estimate = path.trajectory;
  sort_trajectory(estimate);
  EvaluationSettings settings;
  settings.association = Association::interpolate_truth;
  try {
    return evaluate(truth(), estimate, settings);
  } catch (const std::invalid_argument& problem) {  // nothing matches, or not yet
    if (why != nullptr) *why = problem.what();
    return std::nullopt;
  }
}

bool RunRecorder::source_finished() const {
  const auto camera = board_.find("camera");
  return camera != board_.end() && camera->second.state == status_t::FINISHED;
}

bool RunRecorder::source_failed(std::string& reason) const {
  const auto camera = board_.find("camera");
  if (camera == board_.end() || camera->second.state != status_t::FAILED) return false;
  reason = camera->second.detail;
  return true;
}

}  // namespace lcmslam
