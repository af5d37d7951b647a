#pragma once
// ENCODERS, TWIST, FEATURES or another driver's pose_t -> ODOMETRY: of the source that the settings name, or
// of the best that arrives.

#include <lcmslam/encoders_t.hpp>
#include <lcmslam/odometry/external_odometry.hpp>
#include <lcmslam/odometry/motion_noise.hpp>
#include <lcmslam/odometry/twist_odometry.hpp>
#include <lcmslam/odometry/visual_odometry.hpp>
#include <lcmslam/odometry/wheel_odometry.hpp>
#include <lcmslam/odometry_t.hpp>
#include <lcmslam/pose_t.hpp>
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
  /// Of one source; while nobody has chosen, each message is a reason to choose it. FEATURES also tell that
  /// time goes on while a twist holds.
  template <class M>
  void listen(Inputs& inputs, OdometrySource source, std::size_t capacity,
              std::function<void(const M&)> handler);
  bool takes(OdometrySource source, Utime utime);
  const char* source() const { return name_of(*choice_.chosen(), odometry_sources); }
  void on_pose(const pose_t& message);
  void on_encoders(Encoders encoders);
  void on_twist(Twist twist);
  void hold_twist(Utime now);
  void publish_twist(const MotionSample& sample);
  void on_features(const FeatureFrame& frame);
  void publish(const MotionSample& sample, odometry_t message);

  Publisher& publisher_;
  SourceChoice choice_;
  bool named_;  // by the settings
  std::string external_channel_;
  Utime clock_offset_;       // us, from other sources' stamps to the camera's
  std::size_t frame_queue_;  // frames that may wait
  WheelOdometry wheels_;
  TwistOdometry twist_;
  Utime clock_ = 0;  // of the newest FEATURES
  VisualOdometry visual_;
  std::optional<MotionNoise> noise_;
  ExternalOdometry external_;
  std::int64_t updates_ = 0;
  std::int64_t degraded_ = 0;  // visual updates that went on by prediction
  std::string came_later_;     // channel of a better source than the chosen one
};

}  // namespace lcmslam
