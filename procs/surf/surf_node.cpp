#include "procs/surf/surf_node.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/rgbd/camera_motion.hpp>
#include <lcmslam/rgbd/describe_frame.hpp>

namespace lcmslam {
namespace {

// Whether images fit the calibration is looked at in the first frames, some way apart, and said early.
constexpr int looked_at = 12, enough_to_say = 4, motions_looked_at = 60;
constexpr Utime look_period = 1'000'000;  // us

/// Full of blobs, before a wall.
RgbdFrame any_frame(const RgbdCalibration& calibration) {
  const CameraModel& colour = calibration.colour;
  constexpr int blob = 8;  // pixels
  cv::Mat noise(1 + colour.height / blob, 1 + colour.width / blob, CV_8UC3);
  cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 256);
  RgbdFrame frame;
  cv::resize(noise, frame.colour, {colour.width, colour.height}, 0, 0, cv::INTER_CUBIC);
  frame.depth = cv::Mat(calibration.depth.height, calibration.depth.width, CV_16UC1, cv::Scalar(1500));
  return frame;
}

}  // namespace

SurfNodeSettings SurfNode::read(const ConfigNode& config) {
  auto settings = read_settings<SurfNodeSettings>(config);
  AdaptiveThresholdSettings& t = settings.threshold;
  t.start = settings.surf.hessian_threshold;
  t.lowest = std::min(t.start, t.lowest);
  t.highest = std::max(t.start, t.highest);
  t.wanted = 2 * settings.surf.budget.max_features;  // a choice to spread over the image
  return settings;
}

SurfNode::SurfNode(const ConfigNode& config, Publisher& publisher) : SurfNode(read(config), publisher) {}

SurfNode::SurfNode(const SurfNodeSettings& settings, Publisher& publisher)
    : publisher_(publisher),
      surf_(settings.surf),
      threshold_(settings.threshold),
      range_error_settings_(settings.range_error),
      drop_folded_(settings.drop_folded),
      support_(settings.support),
      period_(settings.rate > 0 ? 1e6 / settings.rate : 0),
      frame_queue_(static_cast<std::size_t>(settings.frame_queue)) {}

void SurfNode::connect(Inputs& inputs) {
  inputs.on_new_session = [this] { motion_ = MotionBuffer(); };
  stamps_ = &inputs.stamps();
  inputs.subscribe_measured<images_t>("CAMERA", frame_queue_, [this](const images_t& m) { on_camera(m); })
      .primary = true;
  inputs.subscribe<camera_calibration_t>("CAMERA_CALIBRATION", 10,
                                         [this](const camera_calibration_t& m) { on_calibration(m); });
  inputs.subscribe_measured<odometry_t>("ODOMETRY", 200, [this](const odometry_t& m) { on_odometry(m); });
}

void SurfNode::on_calibration(const camera_calibration_t& message) {
  if (registration_ && is_of_another_camera(message.sender, calibration_message_.sender, *stamps_)) return;
  if (registration_ && same_calibration(message, calibration_message_)) {
    calibration_message_.sender = message.sender;
    return;
  }
  registration_.emplace(from_message(message));
  range_error_.emplace(registration_->calibration(), range_error_settings_);
  if (drop_folded_) folded_.emplace(registration_->calibration());
  plausibility_.emplace(registration_->calibration());
  mount_motion_.reset();
  if (registration_->calibration().has_mount)
    mount_motion_.emplace(registration_->calibration().T_robot_camera);
  doubt_.clear();
  motion_doubt_.clear();
  calibration_message_ = message;
  if (uncalibrated_)
    on_camera(*std::exchange(uncalibrated_, std::nullopt));
  else
    warm_up();
}

// The first image makes buffers and threads and takes as long as ten others, and those that come meanwhile
// would be skipped: while none waits, one that says nothing goes before it.
void SurfNode::warm_up() {
  describe_frame(any_frame(registration_->calibration()), *registration_, Eigen::Isometry3d::Identity(),
                 surf_);
}

// Another sender's path begins elsewhere.
void SurfNode::on_odometry(const odometry_t& message) {
  if (message.source == "visual") return;
  if (message.sender != odometry_sender_) motion_ = MotionBuffer();
  odometry_sender_ = message.sender;
  motion_.add(from_message(message));
}

void SurfNode::on_camera(const images_t& message) {
  if (!registration_) {
    uncalibrated_ = message;
    return;
  }
  if (too_soon(message.utime)) return;
  RgbdFrame frame = decode_images(message, registration_->calibration());
  no_depth_ = cv::countNonZero(frame.depth) == 0;
  if (folded_) (*folded_)(frame.depth, frame.amplitude);
  range_error_->learn(frame.depth, frame.depth_utime);
  range_error_->correct(frame.depth);
  FeatureFrame features = describe(frame);
  for (Feature& feature : features.features)
    if (feature.kind == MeasurementKind::point)
      feature.depth_sigma =
          static_cast<float>(range_error_->remaining(feature.depth_sigma, feature.point.norm()));
  publisher_.publish("FEATURES", to_message(features));
  ++frames_;
  look_at(frame);
  look_at(features);
}

void SurfNode::look_at(const FeatureFrame& frame) {
  if (!mount_motion_) return;
  constexpr Utime longest_gap = 60'000;  // us
  mount_motion_->add(frame, [this](Utime from, Utime to) { return motion_.between(from, to, longest_gap); });
  const std::string finding = mount_motion_->finding();
  motion_doubt_ = finding.empty() ? "" : "looks wrong: " + finding;
  if (mount_motion_->motions() >= motions_looked_at) mount_motion_.reset();
}

void SurfNode::look_at(const RgbdFrame& frame) {
  if (frames_ == 1) looked_ = frame.utime;  // it has taken long enough
  const bool due = frame.utime < looked_ || frame.utime - looked_ >= look_period;
  if (!plausibility_ || !due) return;
  looked_ = frame.utime;
  plausibility_->add(frame);
  if (plausibility_->frames() < enough_to_say) return;
  const auto findings = plausibility_->findings();
  doubt_ = findings.empty() ? "" : "looks wrong: " + findings.front();
  if (plausibility_->frames() >= looked_at) plausibility_.reset();
}

// Images come with some jitter: one a quarter of a period early is taken, the next one is due as if it had
// not been.
bool SurfNode::too_soon(Utime utime) {
  const auto period = static_cast<Utime>(period_);
  const bool begins = due_ == 0 || utime < last_utime_;
  if (!begins && utime < due_ - period / 4) {
    ++left_out_;
    return true;
  }
  due_ = (begins ? utime : std::max(due_, utime - period)) + period;
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
  const Eigen::Isometry3d T_colour_depth_time = motion_between_shots(frame);
  FeatureFrame result = describe_frame(frame, *registration_, T_colour_depth_time, surf_);
  straddling_ =
      leave_out_straddling(frame, registration_->calibration(), T_colour_depth_time, support_, result);
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
  else if (frames_ > 0 && threshold_.at_lowest() && 2 * keypoints_ < surf_.settings().budget.max_features)
    report.detail = fmt::format("little texture: {:.0f} keypoints at the lowest threshold", keypoints_);
  if (frames_ > 0 && no_depth_) report.detail = "the depth image shows nothing";
  if (registration_ && !motion_doubt_.empty()) report.detail = motion_doubt_;
  if (registration_ && !doubt_.empty()) report.detail = doubt_;
  report.values = {{"frames", static_cast<double>(frames_)},
                   {"left_out", static_cast<double>(left_out_)},
                   {"keypoints", keypoints_},
                   {"with_depth", with_depth_},
                   {"straddling", static_cast<double>(straddling_)},
                   {"threshold", threshold_.value()},
                   {"sharpness", last_sharpness_},
                   {"blurred_frames", static_cast<double>(blurred_frames_)}};
  return report;
}

}  // namespace lcmslam
