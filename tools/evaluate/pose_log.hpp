#pragma once
// The trajectories that an LCM log holds.

#include <map>
#include <optional>
#include <string>

#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/messages/followed_graph.hpp>

namespace lcmslam {

/// What one channel says of a body's path.
struct PoseChannel {
  std::string type;              ///< of its messages, e.g. pose_estimate_t
  std::string body;              ///< the frame whose pose it is: "robot", "camera" ...
  std::string frame;             ///< in which they are given: "map", "odom" ...; empty: not said
  std::string source;            ///< odometry_t's: wheels, visual ...
  Trajectory trajectory;         ///< sorted; of the newest map where a mapper began again
  int lost = 0, degraded = 0;    ///< poses of the trajectory with that status
  int restarts = 0;              ///< new maps (restart, reset, time jump)
  std::int64_t left_out = 0;     ///< poses of earlier maps
  int earlier_lost = 0;          ///< of those with status LOST
  std::int64_t unplaced = 0;     ///< poses that the last graph does not place (X_FINAL)
  std::int64_t undecodable = 0;  ///< messages that were no poses
  /// Newest graph node before each pose, and the pose as seen from it (utime stands in the trajectory).
  struct RelativePose {
    Utime utime = 0;
    std::int32_t node = 0;
    Eigen::Isometry3d T_node_robot = Eigen::Isometry3d::Identity();
  };
  std::vector<RelativePose> relative_poses;
  bool is_ground_truth() const { return type == "ground_truth_t"; }
};

/// Collects the poses of a log's messages, in the log's order.
class PoseLog {
 public:
  /// A message of a type without poses is noted, nothing else.
  void add(const std::string& channel, const std::uint8_t* data, std::size_t size);
  /// Sorts the trajectories; after the last message. `damages`: places where the log could not be read.
  void finish(std::size_t damages = 0);

  /// Channels with poses, by name. A mapper that sends its graph has one more, X_FINAL beside X_POSE: its
  /// path as the last graph has it, each pose moved with the keyframe before it.
  const std::map<std::string, PoseChannel>& channels() const { return channels_; }
  /// Throws std::runtime_error naming `log`, what the channel carries instead, and the channels that would
  /// do.
  const PoseChannel& channel(const std::string& name, const std::string& log) const;
  std::size_t damages() const { return damages_; }
  /// The first one.
  const std::optional<RgbdCalibration>& calibration() const { return calibration_; }

 private:
  struct Mapper {
    std::int64_t sender = 0, map_revision = 0;
  };
  void add_relative_pose(const std::string& channel, const StampedPose& pose, std::int64_t sender);
  void add_final_paths();
  void add_pose(const std::string& channel, const StampedPose& pose, std::int64_t sender, int status,
                std::int64_t map_revision);

  std::map<std::string, PoseChannel> channels_;
  std::map<std::string, Mapper> mappers_;
  using Nodes = std::map<std::int32_t, Eigen::Isometry3d>;                  // T_map_camera
  std::map<std::pair<std::int64_t, std::string>, FollowedGraph> followed_;  // by sender and frame
  std::map<std::int64_t, Nodes> graphs_;                                    // the newest of each sender
  /// A node that a graph has given up, as seen from the nearest one that stayed.
  struct Successor {
    std::int32_t node = 0;
    Eigen::Isometry3d T_successor_gone = Eigen::Isometry3d::Identity();
  };
  std::map<std::int64_t, std::map<std::int32_t, Successor>> successors_;  // by sender and node
  void add_graph(std::int64_t sender, Nodes nodes);
  std::optional<Eigen::Isometry3d> final_pose(std::int64_t sender, std::int32_t node) const;
  std::map<std::string, std::string> others_;  // what the other channels carry
  std::optional<RgbdCalibration> calibration_;
  std::size_t damages_ = 0;
};

/// Every whole event of it. Throws std::runtime_error when the file is missing or is no LCM log.
PoseLog read_pose_log(const std::string& file);

/// Whether a file is called .lcmlog or begins as an LCM log does.
bool is_log(const std::string& file);

}  // namespace lcmslam
