#pragma once
// CAMERA + ODOMETRY -> ICP_POSE (and in two parts, ICP_LOCAL_POSE, which never jumps, and ICP_CORRECTION),
// ICP_KEYFRAME, ICP_GRAPH, ICP_GRAPH_COVARIANCE, ICP_REPORT.

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include <lcmslam/features_t.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/messages/graph_teller.hpp>
#include <lcmslam/rgbd/rgbd_frame_maker.hpp>
#include <lcmslam/runtime/motion_join.hpp>
#include <lcmslam/runtime/node.hpp>
#include "procs/icp/icp_node_settings.hpp"
#include "procs/icp/keyframe_teller.hpp"

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
  using Prepared = RgbdFrameMaker::Prepared;

  void on_camera(const images_t& message);
  void on_calibration(const camera_calibration_t& message);
  void on_features(const features_t& message);
  void on_frame(Prepared& prepared);
  RgbdFrameMaker::LateColour late(EncodedImage image);
  void begin_session();
  void begin_map_beside();
  void look_for_place(bool searched, double seconds);
  bool is_elsewhere() const;
  void finish_map();
  KeyframeTeller::Map map() { return {*mapper_, map_frame(), maker_.calibration().T_robot_camera}; }
  std::string map_frame() const { return map_frame_of(first_map_frame_, session_); }
  void learn_clock(const RgbdFrameMaker::Made& made);
  void publish(Utime image_utime, const RgbdFrameMaker::Made& made, double cpu_time);
  void publish_graph(bool all);

  Publisher& publisher_;
  DenseMapperSettings settings_;
  std::string pose_;  // "auto": on the ground when the camera is mounted on a robot
  std::string first_map_frame_;
  std::size_t frame_queue_;                      // frames that may wait
  double new_map_after_, new_map_when_carried_;  // s
  RgbdFrameMaker maker_;
  MotionJoin<Prepared> join_;
  camera_calibration_t calibration_message_;
  std::optional<images_t> uncalibrated_;  // the newest message that came before the calibration
  std::optional<DenseMapper> mapper_;
  DenseMapper::Step last_;
  Eigen::Isometry3d T_world_previous_ = Eigen::Isometry3d::Identity();  // of the step before last_
  Utime last_utime_ = 0;
  Vector6d twist_ = Vector6d::Zero();  // per second, at the last step
  double searched_ = 0;                // s of frames that showed something, since it is adrift
  GraphTeller graph_teller_;
  KeyframeTeller keyframe_teller_{publisher_};
  std::int64_t session_ = 1;  // maps begun; each has a frame of its own
  std::int64_t steps_ = 0, lost_ = 0, uncoloured_ = 0, with_features_ = 0, without_features_ = 0,
               anchored_ = 0, gaps_ = 0, off_ground_ = 0, blind_ = 0;
  const StampJudge* stamps_ = nullptr;
};

}  // namespace lcmslam
