#pragma once
// Listens to a running graph and keeps what an evaluation needs: every trajectory, the truth, the
// state of the processes.

#include <optional>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/evaluation/trajectory_error.hpp>
#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/runtime/inputs.hpp>
#include "tools/launch/status_table.hpp"

namespace lcmslam {

/// A path of which only every so many-th pose is kept: a run of days must not fill the memory.
struct ThinnedPath {
  Trajectory trajectory;
  int every = 1;
  std::int64_t heard = 0;  ///< poses, kept or not

  /// Keeps every second pose, of those that follow too, whenever there are `most` of them.
  void add(const StampedPose& pose, std::size_t most);
};

/// One estimate of the robot's path (T_x_robot, x: odom or map) and how its maker fared.
struct RecordedPath : ThinnedPath {
  std::int64_t sender = 0;
  std::int64_t map_revision = 0;
  int lost = 0, degraded = 0;  ///< poses with that status
  int restarts = 0;  ///< it began a new map (restart, reset, time jump); the trajectory is the newest map's
};

class RunRecorder {
 public:
  /// Registers its handlers.
  explicit RunRecorder(Inputs& inputs);

  const RecordedPath& odometry() const { return odometry_; }
  const RecordedPath& fastslam() const { return fastslam_; }
  const RecordedPath& icp() const { return icp_; }
  /// T_world_robot; empty when the source has no truth, or one of a body that nobody places on the robot.
  Trajectory truth() const;
  /// Why there is no truth() although some was heard; empty otherwise.
  std::string truth_problem() const;
  /// The last one; empty when the source sends none.
  const std::optional<camera_calibration_t>& calibration_message() const { return calibration_message_; }
  const StatusBoard& board() const { return board_; }
  const std::optional<map_reply_t>& reply() const { return reply_; }

  /// Error against the truth so far; nothing without truth, or where the path cannot be compared with it:
  /// `why` is told the reason then.
  std::optional<TrajectoryReport> evaluate_path(const RecordedPath& path, std::string* why = nullptr) const;

  /// The source has published everything.
  bool source_finished() const;
  bool source_failed(std::string& reason) const;
  /// Poses received so far: when the number rests, the mappers have worked off what they had.
  std::int64_t progress() const { return messages_; }

 private:
  void add(RecordedPath& path, Utime utime, std::int64_t sender, std::int8_t status,
           const Eigen::Isometry3d& pose, std::int64_t map_revision = 0);

  RecordedPath odometry_, fastslam_, icp_;
  ThinnedPath truth_;  // of truth_frame_
  std::string truth_frame_ = "robot";
  std::optional<RgbdCalibration> calibration_;
  std::optional<camera_calibration_t> calibration_message_;
  std::int64_t messages_ = 0;
  StatusBoard board_;
  std::optional<map_reply_t> reply_;
};

}  // namespace lcmslam
