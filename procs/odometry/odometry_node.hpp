#pragma once
// ENCODERS, TWIST, FEATURES or another driver's pose_t -> ODOMETRY.

#include <lcmslam/encoders_t.hpp>
#include <lcmslam/odometry/external_odometry.hpp>
#include <lcmslam/odometry/motion_noise.hpp>
#include <lcmslam/odometry/twist_odometry.hpp>
#include <lcmslam/odometry/visual_odometry.hpp>
#include <lcmslam/odometry/wheel_odometry.hpp>
#include <lcmslam/odometry_t.hpp>
#include <lcmslam/runtime/node.hpp>
#include <lcmslam/twist_t.hpp>
#include "procs/odometry/odometry_settings.hpp"

namespace lcmslam {

class OdometryNode : public Node {
 public:
  using Settings = OdometryNodeSettings;
  static Settings read(const ConfigNode& config);

  OdometryNode(const ConfigNode& config, Publisher& publisher);
  OdometryNode(const Settings& settings, Publisher& publisher);

  void connect(Inputs& inputs) override;
  NodeReport report() const override;

 private:
  void on_encoders(const Encoders& encoders);
  void on_twist(const Twist& twist);
  void on_features(const FeatureFrame& frame);
  void publish(const MotionSample& sample, odometry_t message);

  Publisher& publisher_;
  std::string source_;
  std::string external_channel_;
  std::size_t frame_queue_;  // frames that may wait
  WheelOdometry wheels_;
  TwistOdometry twist_;
  VisualOdometry visual_;
  std::optional<MotionNoise> noise_;
  ExternalOdometry external_;
  std::int64_t updates_ = 0;
  std::int64_t degraded_ = 0;  // visual updates that went on by prediction
};

}  // namespace lcmslam
