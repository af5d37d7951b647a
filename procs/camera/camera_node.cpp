#include "procs/camera/camera_node.hpp"

#include <spdlog/spdlog.h>

#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/runtime/machine.hpp>
#include <lcmslam/runtime/status_reporter.hpp>
#include <lcmslam/status_t.hpp>
#include "procs/camera/publish_event.hpp"

namespace lcmslam {
namespace {

constexpr std::size_t frames_ahead = 10;  // a third of a second in which the machine may be busy otherwise
constexpr std::size_t live_frames_ahead = 3;
constexpr std::chrono::milliseconds tolerated_delay{200};
constexpr std::chrono::milliseconds calibration_period{1000}, soonest_calibration{100};

}  // namespace

CameraNode::CameraNode(const ConfigNode& config, Publisher& publisher, OpenSource open)
    : CameraNode(read(config), publisher, open) {}

CameraNode::CameraNode(const CameraSettings& settings, Publisher& publisher, OpenSource open)
    : publisher_(publisher),
      source_(open(settings)),
      wait_for_(settings.wait_for.begin(), settings.wait_for.end()),
      pace_(settings.speed) {
  const std::chrono::duration<double> patience(settings.wait_at_most);
  wait_until_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(patience);
  if (!source_->relays().empty()) foreign_.emplace(source_->relays(), source_->calibration(), settings.live);
  for (const auto& note : source_->notes()) spdlog::info("{}", note);
  thread_ = std::thread([this] { prefetch(); });
}

CameraNode::~CameraNode() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  source_->stop();
  thread_.join();
}

void CameraNode::connect(Inputs& inputs) {
  inputs.subscribe<status_t>("STATUS", 100, [this](const status_t& status) {
    if (status.state == status_t::RUNNING) wait_for_.erase(status.process);
    calibration_asked_ |= just_started(status);
  });
  if (source_->calibrates_only())
    inputs.subscribe<images_t>("CAMERA", 1, [this](const images_t& images) { on_foreign_images(images); });
  if (foreign_)
    inputs.subscribe<images_t>(source_->relays(), 2, [this](const images_t& images) { relay(images); });
}

void CameraNode::relay(const images_t& images) {
  if (const auto frame = foreign_->relay(images)) publish(*frame);
}

void CameraNode::on_foreign_images(const images_t& images) {
  last_utime_ = images.utime;
  misfit_.clear();
  try {
    checked_images(images, source_->calibration());
  } catch (const DecodeError& error) {
    misfit_ = error.what();
  }
}

void CameraNode::prefetch() {
  yield_to_receivers();
  try {
    while (auto event = source_->next()) {
      std::unique_lock<std::mutex> lock(mutex_);
      if (source_->is_live())
        make_room();
      else
        changed_.wait(lock, [&] { return stop_ || ready_frames_ < frames_ahead; });
      if (stop_) return;
      ready_frames_ += std::holds_alternative<EncodedFrame>(*event) ? 1 : 0;
      ready_.push_back(std::move(*event));
      if (malformed_ == 0 && source_->malformed() > 0) warn();
      malformed_ = source_->malformed();
    }
  } catch (const std::exception& error) {
    spdlog::error("source failed: {}", error.what());
    const std::lock_guard<std::mutex> lock(mutex_);
    failure_ = error.what();
  }
  warn();
  const std::lock_guard<std::mutex> lock(mutex_);
  malformed_ = source_->malformed();
  source_ended_ = true;
}

/// A camera does not wait: what nobody took in time is out of date.
void CameraNode::make_room() {
  for (; ready_.size() >= live_frames_ahead; ++skipped_) {
    ready_frames_ -= std::holds_alternative<EncodedFrame>(ready_.front()) ? 1 : 0;
    ready_.pop_front();
  }
}

void CameraNode::warn() const {
  for (const auto& warning : source_->warnings()) spdlog::warn("{}", warning);
}

std::optional<CameraEvent> CameraNode::pop() {
  std::optional<CameraEvent> event;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (ready_.empty()) return std::nullopt;
    event = std::move(ready_.front());
    ready_.pop_front();
    ready_frames_ -= std::holds_alternative<EncodedFrame>(*event) ? 1 : 0;
  }
  changed_.notify_all();
  return event;
}

bool CameraNode::consumers_ready() {
  if (wait_for_.empty()) return true;
  if (Clock::now() < wait_until_) return false;
  for (const auto& name : wait_for_) spdlog::warn("starts without {}, which has not reported", name);
  wait_for_.clear();
  return true;
}

std::optional<Node::Duration> CameraNode::work() {
  const auto now = Clock::now();
  if (now >= calibrated_ + (calibration_asked_ ? soonest_calibration : calibration_period))
    publish_calibration();
  if (!consumers_ready()) return std::chrono::milliseconds(20);

  if (!next_) next_ = pop();
  if (!next_) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (source_ended_ && ready_.empty()) return calibrated_ + calibration_period - now;
    return std::chrono::milliseconds(2);
  }
  if (source_->is_live()) {
    publish(*next_);
    next_.reset();
    return Duration{0};
  }
  if (!due_) due_ = due(*next_, now);
  if (*due_ > now) return *due_ - now;
  if (now - *due_ > tolerated_delay) {  // cannot keep the pace: go slower rather than leave frames out
    pace_.delay(now - *due_);
    slowed_ += std::chrono::duration<double>(now - *due_).count();
  }
  publish(*next_);
  next_.reset();
  due_.reset();
  return Duration{0};
}

CameraNode::Clock::time_point CameraNode::due(const CameraEvent& event, Clock::time_point now) {
  const bool leapt = pace_.leaps() > 0;
  const auto time = pace_.due(event.index(), event_utime(event), now);
  if (!leapt && pace_.leaps() > 0)
    spdlog::warn(
        "the stamps leap to {} us: what follows goes out at once, and at its intervals from there on",
        event_utime(event));
  return time;
}

void CameraNode::publish(const CameraEvent& event) {
  last_utime_ = event_utime(event);
  publish_event(publisher_, event);
  frames_sent_ += std::holds_alternative<EncodedFrame>(event) ? 1 : 0;
}

void CameraNode::publish_calibration() {
  camera_calibration_t message = to_message(source_->calibration());
  message.utime = last_utime_;
  publisher_.publish("CAMERA_CALIBRATION", message);
  calibrated_ = Clock::now();
  calibration_asked_ = false;
}

NodeReport CameraNode::report() const {
  const SourceHealth health = foreign_ ? foreign_->health() : source_->health();
  const std::lock_guard<std::mutex> lock(mutex_);
  NodeReport report;
  if (!failure_.empty()) {
    report.state = status_t::FAILED;
    report.detail = failure_;
  } else if (!wait_for_.empty()) {
    report.state = status_t::STARTING;
    report.detail = "waits for " + *wait_for_.begin();
  } else if (source_->calibrates_only()) {
    report.detail = misfit_.empty() ? "calibration for another driver's CAMERA" : misfit_;
  } else if (foreign_ || source_->is_live()) {
    report.detail = health.trouble;
    if (health.silent || frames_sent_ == 0)
      report.state = status_t::STARTING;  // a change of state is told at once
  } else if (source_ended_ && ready_.empty() && !next_) {
    report.state = status_t::FINISHED;
    report.detail = "source is at its end";
  }
  report.values = {{"frames", static_cast<double>(frames_sent_)},
                   {"frames_total", static_cast<double>(source_->frames())},
                   {"malformed_frames", static_cast<double>(malformed_)},
                   {"slowed_seconds", slowed_},
                   {"leaps_of_time", static_cast<double>(pace_.leaps())}};
  report.values.insert(report.values.end(), health.values.begin(), health.values.end());
  if (source_->is_live()) report.values.emplace_back("out_of_date", static_cast<double>(skipped_));
  return report;
}

}  // namespace lcmslam
