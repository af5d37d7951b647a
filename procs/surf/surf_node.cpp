#include "procs/surf/surf_node.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/rgbd/camera_motion.hpp>
#include <lcmslam/rgbd/describe_frame.hpp>
#include <lcmslam/runtime/arrival.hpp>

namespace lcmslam {
namespace {

SurfSettings read_settings(const ConfigNode& config) {
  SurfSettings s;
  s.hessian_threshold = config.get("hessian_threshold", s.hessian_threshold, Range{1e-3, 1e6});
  s.octaves = config.get("octaves", s.octaves, Range{1, 6});
  s.intervals = config.get("intervals", s.intervals, Range{3, 8});
  s.smooth = config.get("smooth", s.smooth);
  s.upright = config.get("upright", s.upright);
  s.budget.max_features = config.get("max_features", s.budget.max_features, Range{1, 5000});
  return s;
}

AdaptiveThresholdSettings read_threshold(const ConfigNode& config, const SurfSettings& surf) {
  AdaptiveThresholdSettings s;
  s.start = surf.hessian_threshold;
  s.lowest = std::min(s.start, config.get("lowest_threshold", s.lowest, Range{1e-3, 1e6}));
  s.highest = std::max(s.start, config.get("highest_threshold", s.highest, Range{1e-3, 1e6}));
  s.wanted = 2 * surf.budget.max_features;  // a choice to spread over the image
  return s;
}

/// us; 0: every image.
double read_period(const ConfigNode& config) {
  const double rate = config.get("rate", 0.0, Range{0, 1000});
  return rate > 0 ? 1e6 / rate : 0;
}

}  // namespace

SurfNode::SurfNode(const ConfigNode& config, Publisher& publisher)
    : publisher_(publisher),
      surf_(read_settings(config)),
      threshold_(read_threshold(config, surf_.settings())),
      period_(read_period(config)),
      frame_queue_(frame_queue(config, 2)) {}

void SurfNode::connect(Inputs& inputs) {
  inputs.subscribe<images_t>("CAMERA", frame_queue_, [this](const images_t& m) { on_camera(m); }).primary =
      true;
  inputs.subscribe<camera_calibration_t>("CAMERA_CALIBRATION", 10,
                                         [this](const camera_calibration_t& m) { on_calibration(m); });
  inputs.subscribe<odometry_t>("ODOMETRY", 200, [this](const odometry_t& m) { on_odometry(m); });
}

void SurfNode::on_calibration(const camera_calibration_t& message) {
  if (registration_ && same_calibration(message, calibration_message_)) return;
  registration_.emplace(from_message(message));
  calibration_message_ = message;
  if (uncalibrated_) on_camera(*std::exchange(uncalibrated_, std::nullopt));
}

void SurfNode::on_odometry(const odometry_t& message) {
  if (message.source == "visual") return;
  const MotionSample sample = from_message(message);
  if (!came_late_or_twice(sample.utime, motion_.newest())) motion_.add(sample);
}

void SurfNode::on_camera(const images_t& message) {
  if (!registration_) {
    uncalibrated_ = message;
    return;
  }
  if (too_soon(message.utime)) return;
  publisher_.publish("FEATURES", to_message(describe(decode_images(message, registration_->calibration()))));
  ++frames_;
}

// Images come with some jitter: three quarters of the period are enough.
bool SurfNode::too_soon(Utime utime) {
  const auto since = static_cast<double>(utime - last_utime_);
  if (since >= 0 && since < 0.75 * period_) {
    ++left_out_;
    return true;
  }
  last_utime_ = utime;
  return false;
}

Eigen::Isometry3d SurfNode::motion_between_shots(const RgbdFrame& frame) const {
  const RgbdCalibration& c = registration_->calibration();
  // Odometry's newest sample is a little older than the images: the last velocity bridges the gap.
  constexpr Utime longest_gap = 60'000;
  const auto motion = motion_.between(frame.utime, c.depth_time(frame.depth_utime), longest_gap);
  if (!motion) return Eigen::Isometry3d::Identity();
  return camera_motion(*motion, c.T_robot_camera);
}

FeatureFrame SurfNode::describe(const RgbdFrame& frame) {
  surf_.set_hessian_threshold(threshold_.value());
  const RegisteredDepth depth = registration_->for_depth_at_pixels(frame, motion_between_shots(frame));
  FeatureFrame result = describe_frame(frame, depth, registration_->calibration(), surf_);
  threshold_.observe(surf_.blobs_found());
  blurred_ = sharpness_.observe(result.sharpness);
  blurred_frames_ += blurred_ ? 1 : 0;
  last_sharpness_ = result.sharpness;
  keypoints_ = static_cast<double>(result.features.size());
  with_depth_ =
      static_cast<double>(std::count_if(result.features.begin(), result.features.end(),
                                        [](const Feature& f) { return f.kind == MeasurementKind::point; }));
  return result;
}

NodeReport SurfNode::report() const {
  NodeReport report;
  if (!registration_)
    report.detail = "waits for CAMERA_CALIBRATION";
  else if (blurred_)
    report.detail =
        fmt::format("image blurred: sharpness {:.1f}, usually {:.1f}", last_sharpness_, sharpness_.usual());
  else if (threshold_.at_lowest() && frames_ > 0)
    report.detail = fmt::format("little texture: {:.0f} keypoints at the lowest threshold", keypoints_);
  report.values = {{"frames", static_cast<double>(frames_)},
                   {"left_out", static_cast<double>(left_out_)},
                   {"keypoints", keypoints_},
                   {"with_depth", with_depth_},
                   {"threshold", threshold_.value()},
                   {"sharpness", last_sharpness_},
                   {"blurred_frames", static_cast<double>(blurred_frames_)}};
  return report;
}

}  // namespace lcmslam
