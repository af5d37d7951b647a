#pragma once
// FEATURES + ODOMETRY (+ CAMERA_CALIBRATION: how long rows are read) -> FASTSLAM_POSE (and in two parts,
// FASTSLAM_LOCAL_POSE, which never jumps, and FASTSLAM_CORRECTION), FASTSLAM_PARTICLES,
// FASTSLAM_ASSOCIATIONS, FASTSLAM_LANDMARKS; at the end, and on the command "smooth", FASTSLAM_SMOOTHED: the
// path again as all measurements together show it.

#include <lcmslam/fastslam/fastslam.hpp>
#include <lcmslam/features/feature.hpp>
#include <lcmslam/runtime/motion_join.hpp>
#include <lcmslam/runtime/node.hpp>
#include "procs/fastslam/fastslam_node_settings.hpp"
#include "procs/told_calibration.hpp"

namespace lcmslam {

class FastSlamNode : public Node {
 public:
  using Settings = FastSlamNodeSettings;
  static Settings read(const ConfigNode& config);

  FastSlamNode(const ConfigNode& config, Publisher& publisher);
  FastSlamNode(const Settings& settings, Publisher& publisher);

  void connect(Inputs& inputs) override;
  void command(const command_t& command) override;
  void finish() override;
  NodeReport report() const override;

 private:
  void on_features(const FeatureFrame& frame);
  void start(const FeatureFrame& frame);
  void begin_session();
  void begin_map_beside();
  bool is_elsewhere() const;
  std::string map_frame() const { return map_frame_of(first_map_frame_, session_); }
  Motion motion_to(Utime utime) const;
  void remember_guess(Utime utime);
  void publish(const FeatureFrame& frame, const StepResult& result, double cpu_time);
  void publish_changes(Utime utime);
  void publish_whole_map();
  void publish_smoothed(const std::vector<SmoothedPose>& path);

  Publisher& publisher_;
  FastSlamSettings settings_;
  std::string pose_;  // "auto": planar when the camera is mounted on a robot
  std::string first_map_frame_;
  std::size_t frame_queue_;                      // frames that may wait
  double new_map_after_, new_map_when_carried_;  // s
  MotionJoin<FeatureFrame> join_;
  CameraShutter shutter_;
  std::optional<FastSlam> slam_;
  Utime last_utime_ = 0;
  /// Where the last step took odometry to be, ahead of its newest word, and no measurement has put that
  /// right.
  struct Guess {
    std::int64_t sender;
    Eigen::Isometry3d T_odom_robot;
  };
  std::optional<Guess> guess_;
  std::int64_t revision_ = 0;
  StepResult last_;
  std::int64_t session_ = 1;  // maps begun; each has a frame of its own
  std::int64_t steps_ = 0, lost_ = 0, gaps_ = 0, off_ground_ = 0;
};

}  // namespace lcmslam
