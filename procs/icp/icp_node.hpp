#pragma once
// CAMERA + ODOMETRY -> ICP_POSE, ICP_KEYFRAME, ICP_GRAPH, ICP_REPORT.

#include <deque>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/dense_mapper/icp_mapper.hpp>
#include <lcmslam/features_t.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/rgbd/depth_view.hpp>
#include <lcmslam/runtime/motion_join.hpp>
#include <lcmslam/runtime/node.hpp>
#include "procs/icp/icp_node_settings.hpp"

namespace lcmslam {

class IcpNode : public Node {
 public:
  using Settings = IcpNodeSettings;
  static Settings read(const ConfigNode& config);

  IcpNode(const ConfigNode& config, Publisher& publisher);
  IcpNode(const Settings& settings, Publisher& publisher);

  void connect(Inputs& inputs) override;
  std::optional<Duration> work() override;
  void command(const command_t& command) override;
  void finish() override;
  NodeReport report() const override;

 private:
  /// What can be done with an image before odometry tells of its time.
  struct Prepared {
    RgbdFrame frame;
    EncodedImage colour;  // not decoded yet where only keyframes show it
    DepthView view;
  };

  /// A cloud and the time of the pose from which it is seen.
  struct Shot {
    Utime utime = 0;  // of the points: the colour image's, or depth's while motion is not known
    Utime depth_utime =
        0;  // of the depth image, on colour's clock by the calibration; the pose is told for it
    Eigen::Isometry3d T_points_depth = Eigen::Isometry3d::Identity();  // robot at utime <- at depth_utime
    Cloud cloud;
    Eigen::Isometry3d T_colour_depth_time = Eigen::Isometry3d::Identity();  // camera; as DepthRegistration's
    bool joined = false;                       // images of different moments, motion known
    Vector6d camera_twist = Vector6d::Zero();  // per second; zero while it is not known or does not matter
  };

  void on_camera(const images_t& message);
  void on_calibration(const camera_calibration_t& message);
  void on_frame(Prepared& prepared);
  void on_features(const features_t& message);
  std::optional<FeatureFrame> features_at(const Prepared& prepared, const Shot& shot) const;
  Shot make_shot(const Prepared& prepared) const;
  ColouredCloud paint(Prepared& prepared, const Shot& shot);
  void add_intensities(Prepared& prepared, Shot& shot);
  Utime clock_correction() const;
  void observe_clock(const Shot& shot, const std::optional<Motion>& motion);
  void restart();
  void publish(Utime frame_utime, const Shot& shot, const std::optional<Motion>& motion, double cpu_time);
  void queue_keyframe(const IcpMapper::Keyframe& keyframe);
  void queue_changed(bool all);
  void publish_graph();
  void drop_tiles_of_the_gone();
  void send_waiting_tile();

  Publisher& publisher_;
  IcpMapperSettings settings_;
  DepthFilterSettings filter_settings_;
  std::string pose_;  // "auto": on the floor when the camera is mounted on a robot
  double cloud_points_;
  std::deque<FeatureFrame> features_;  // the newest few
  std::size_t frame_queue_;            // frames that may wait
  MotionJoin<Prepared> join_;
  camera_calibration_t calibration_message_;
  std::optional<RgbdCalibration> calibration_;
  std::optional<DepthRegistration> registration_;
  std::optional<DepthFilter> filter_;
  std::optional<images_t> uncalibrated_;      // the newest message that came before the calibration
  double readout_;                            // s from an image's first row to its last, of
  std::vector<std::string> rolling_sensors_;  // these; their names are the calibrations'
  double rolling_shutter_ = 0;                // s, of the sensor at work
  DepthClock depth_clock_;                    // what the calibration leaves
  std::optional<IcpMapper> mapper_;
  Utime last_utime_ = 0;
  std::deque<keyframe_t> tiles_;  // wait for their turn: bursts overrun receive buffers
  std::int64_t tellings_ = 0;     // of keyframes, over all maps
  std::chrono::steady_clock::time_point next_tile_{};
  std::int64_t steps_ = 0, lost_ = 0, unpainted_ = 0, restarts_ = 0, with_features_ = 0, anchored_ = 0;
  IcpMapper::Step last_;
  Eigen::Isometry3d T_world_previous_ = Eigen::Isometry3d::Identity();  // of the step before last_
};

}  // namespace lcmslam
