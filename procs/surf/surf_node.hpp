#pragma once
// CAMERA -> FEATURES: SURF keypoints of the colour image with their 3-D points from the depth image.

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/features/feature.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/imaging/folded_depth.hpp>
#include <lcmslam/imaging/sharpness.hpp>
#include <lcmslam/odometry_t.hpp>
#include <lcmslam/planes/range_error.hpp>
#include <lcmslam/rgbd/feature_support.hpp>
#include <lcmslam/rgbd/mount_motion.hpp>
#include <lcmslam/rgbd/plausibility.hpp>
#include <lcmslam/runtime/node.hpp>
#include <lcmslam/surf/adaptive_threshold.hpp>
#include <lcmslam/surf/surf.hpp>
#include "procs/surf/surf_settings.hpp"

namespace lcmslam {

class SurfNode : public Node {
 public:
  using Settings = SurfNodeSettings;
  static Settings read(const ConfigNode& config);

  SurfNode(const ConfigNode& config, Publisher& publisher);
  SurfNode(const Settings& settings, Publisher& publisher);

  void connect(Inputs& inputs) override;
  NodeReport report() const override;

 private:
  void on_camera(const images_t& message);
  void on_calibration(const camera_calibration_t& message);
  void on_odometry(const odometry_t& message);
  void warm_up();
  bool too_soon(Utime utime);
  FeatureFrame describe(const RgbdFrame& frame);
  Eigen::Isometry3d motion_between_shots(const RgbdFrame& frame) const;
  void look_at(const RgbdFrame& frame);
  void look_at(const FeatureFrame& frame);

  Publisher& publisher_;
  Surf surf_;
  AdaptiveThreshold threshold_;
  SharpnessWatch sharpness_;
  RangeErrorSettings range_error_settings_;
  bool drop_folded_;
  FeatureSupportSettings support_;
  double period_;            // us between two images that are used, at least
  std::size_t frame_queue_;  // frames that may wait
  camera_calibration_t calibration_message_;
  std::optional<DepthRegistration> registration_;
  std::optional<RangeError> range_error_;
  std::optional<FoldedDepthFilter> folded_;  // none: not to be dropped, or no calibration yet
  std::optional<images_t> uncalibrated_;     // the newest message that came before the calibration
  MotionBuffer motion_;                      // wheel odometry, for the time between the two images
  std::int64_t odometry_sender_ = 0;
  const StampJudge* stamps_ = nullptr;
  Utime last_utime_ = 0, due_ = 0;
  std::int64_t frames_ = 0, left_out_ = 0, blurred_frames_ = 0;
  double keypoints_ = 0, with_depth_ = 0, last_sharpness_ = 0;  // of the newest frame
  int straddling_ = 0;                                          // likewise
  bool blurred_ = false, no_depth_ = false;
  std::optional<Plausibility> plausibility_;  // until a dozen frames were looked at
  Utime looked_ = 0;                          // at the last of them
  std::optional<MountMotion> mount_motion_;   // likewise, some motions
  std::string doubt_, motion_doubt_;          // what looks wrong; empty: nothing
};

}  // namespace lcmslam
