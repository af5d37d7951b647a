#include "tools/study/faults/disturbed_source.hpp"

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include "procs/camera/publish_event.hpp"

namespace lcmslam {
namespace {

bool is(const Fault* fault, FaultKind kind) {
  return fault != nullptr && fault->kind == kind;
}

}  // namespace

EncodedFrame covered(const EncodedFrame& frame) {
  EncodedFrame black = frame;
  const cv::Mat colour = cv::Mat::zeros(frame.colour.height, frame.colour.width, CV_8UC3);
  const cv::Mat depth = cv::Mat::zeros(frame.depth.height, frame.depth.width, CV_16UC1);
  black.colour = encode_colour(colour, frame.colour.utime);
  black.depth = encode_depth(depth, frame.depth.utime);
  if (!frame.amplitude.bytes.empty())
    black.amplitude = encode_amplitude(cv::Mat::zeros(frame.amplitude.height, frame.amplitude.width, CV_8UC1),
                                       frame.amplitude.utime);
  return black;
}

EncodedFrame shifted(EncodedFrame frame, Utime by) {
  frame.utime += by;
  for (EncodedImage* image : {&frame.colour, &frame.depth, &frame.amplitude}) image->utime += by;
  return frame;
}

bool DisturbedSource::publish_until(double elapsed, const Fault* active) {
  while (true) {
    if (!next_) next_ = source_.next();
    if (!next_) return false;
    const Utime utime = event_utime(*next_);
    if (!start_) start_ = utime;
    if (1e-6 * static_cast<double>(utime - *start_) > elapsed) return true;
    newest_ = utime;
    const bool is_gone = utime < gone_until_ && !std::holds_alternative<GroundTruth>(*next_);
    if (is_gone) {
      next_.reset();
      continue;
    }
    if (utime >= gone_until_ && utime - calibrated_ >= 1'000'000) publish_calibration(utime);
    publish(std::move(*next_), active);
    next_.reset();
  }
}

void DisturbedSource::publish_calibration(Utime utime) {
  camera_calibration_t message = to_message(source_.calibration());
  message.utime = utime + jump_;
  publisher_->publish("CAMERA_CALIBRATION", message);
  calibrated_ = utime;
}

void DisturbedSource::publish(CameraEvent event, const Fault* active) {
  if (const auto* frame = std::get_if<EncodedFrame>(&event)) {
    if (!first_) first_ = *frame;
    last_ = shifted(*frame, jump_);
    publish_frame(*last_, active);
  } else if (auto* encoders = std::get_if<Encoders>(&event)) {
    publish_wheels(std::move(*encoders), active);
  } else if (const auto* truth = std::get_if<GroundTruth>(&event)) {
    const Eigen::Isometry3d T_child_robot = truth->child_frame == "camera"
                                                ? source_.calibration().T_robot_camera.inverse()
                                                : Eigen::Isometry3d::Identity();
    truth_.push_back({truth->utime + jump_, truth->T_world_child * T_child_robot});
  }
}

void DisturbedSource::publish_wheels(Encoders encoders, const Fault* active) {
  constexpr double speed = 5;  // rad/s: half a metre in a second where a wheel's radius is 0.1 m
  if (is(active, FaultKind::slip) && wheels_utime_ != 0)
    slipped_ += speed * 1e-6 * static_cast<double>(encoders.utime - wheels_utime_);
  wheels_utime_ = encoders.utime;
  encoders.utime += jump_;
  for (Wheel& wheel : encoders.wheels) wheel.angle += slipped_;
  publish_event(*publisher_, encoders);
}

Trajectory DisturbedSource::truth() const {
  Trajectory truth = truth_;
  sort_trajectory(truth);
  return truth;
}

void DisturbedSource::publish_frame(const EncodedFrame& frame, const Fault* active) {
  if (is(active, FaultKind::silent)) return;
  if (is(active, FaultKind::late)) {
    waiting_.push_back(frame);
    if (waiting_.size() < 5) return;
  }
  for (; !waiting_.empty(); waiting_.pop_front()) {
    publish_event(*publisher_, waiting_.front());
    if (waiting_.front().utime == frame.utime) return waiting_.clear();
  }
  publish_event(*publisher_, is(active, FaultKind::black) ? covered(frame) : frame);
  if (is(active, FaultKind::doubled)) publish_event(*publisher_, frame);
  if (is(active, FaultKind::other_camera))
    publish_event(stranger_, shifted(*first_, frame.utime - first_->utime));
}

void DisturbedSource::begin(const Fault& fault) {
  if (!last_) return;
  if (fault.kind == FaultKind::stamp_ahead) publish_event(*publisher_, shifted(*last_, 10'000'000));
  if (fault.kind == FaultKind::clock_jump) jump_ += 100'000'000;
  if (fault.kind == FaultKind::stamp_zero) publish_event(*publisher_, shifted(*last_, -last_->utime));
}

void DisturbedSource::restart(Publisher& publisher, double seconds) {
  publisher_ = &publisher;
  gone_until_ = newest_ + static_cast<Utime>(1e6 * seconds);
  waiting_.clear();
  calibrate();
}

}  // namespace lcmslam
