#pragma once
// CAMERA -> FEATURES: SURF keypoints of the colour image with their 3-D points from the depth image.

#include "geometry/motion_buffer.hpp"
#include "imaging/registration.hpp"
#include "runtime/node.hpp"
#include "surf/feature.hpp"
#include "surf/surf.hpp"

namespace lcmslam {

class SurfNode : public Node {
 public:
  SurfNode(const ConfigNode& config, Publisher& publisher);

  void connect(Inputs& inputs) override;
  NodeReport report() const override;

 private:
  void on_frame(const EncodedFrame& frame);
  void on_calibration(const RgbdCalibration& calibration);
  FeatureFrame describe(const RgbdFrame& frame);
  Eigen::Isometry3d motion_between_shots(const RgbdFrame& frame) const;

  Publisher& publisher_;
  Surf surf_;
  std::optional<DepthRegistration> registration_;
  std::optional<EncodedFrame> uncalibrated_;  // the newest frame that came before the calibration
  MotionBuffer motion_;                       // wheel odometry, for the time between the two images
  std::int64_t frames_ = 0;
  double keypoints_ = 0, with_depth_ = 0;     // of the newest frame
};

}  // namespace lcmslam
