#include "procs/camera/camera_log.hpp"

#include <map>

#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/messages/parts.hpp>
#include <lcmslam/runtime/log_publisher.hpp>
#include "procs/camera/publish_event.hpp"

namespace lcmslam {
namespace {

constexpr Utime calibration_period = 1'000'000;  // us

/// The event that a message stands for; nothing for channels that are not the camera's.
std::optional<CameraEvent> read_event(const LogEventView& event) {
  if (event.channel == "CAMERA") return from_message(decode_message<images_t>(event.data, event.size));
  if (event.channel == "ENCODERS") return from_message(decode_message<encoders_t>(event.data, event.size));
  if (event.channel != "GROUND_TRUTH") return std::nullopt;
  const auto truth = decode_message<ground_truth_t>(event.data, event.size);
  return GroundTruth{truth.utime, truth.child_frame, from_message(truth.T_frame_child, "T_frame_child")};
}

class LogSource : public CameraSource {
 public:
  explicit LogSource(const std::string& file) : file_(file), log_(file) { scan(); }

  const RgbdCalibration& calibration() const override { return *calibration_; }
  std::size_t frames() const override { return frames_; }
  std::size_t malformed() const override { return malformed_ + log_.damages().size(); }
  std::vector<std::string> notes() const override {
    std::vector<std::string> notes = {file_ + ": " + std::to_string(frames_) + " frames"};
    if (odometry_.count("ENCODERS") > 0) return notes;  // the others are made of them
    for (const auto& [channel, messages] : odometry_)
      notes.push_back(file_ + ": " + std::to_string(messages) + " " + channel +
                      " are not played; `lcmslam log play` plays them");
    return notes;
  }

  std::optional<CameraEvent> next() override {
    while (const auto event = log_.next_view()) {
      try {
        if (auto read = is_piece(*event) ? join(*event) : read_event(*event)) return read;
      } catch (const DecodeError&) {
        ++malformed_;
      }
    }
    return std::nullopt;
  }

 private:
  /// Images that were too big for the recorder's receive buffer came in pieces.
  static bool is_piece(const LogEventView& event) { return event.channel == part_channel("CAMERA"); }
  static bool is_first(const LogEventView& event) {
    try {
      return decode_message<part_t>(event.data, event.size).part == 0;
    } catch (const DecodeError&) {
      return false;
    }
  }
  std::optional<CameraEvent> join(const LogEventView& piece) {
    const auto whole = assembler_.add(decode_message<part_t>(piece.data, piece.size));
    if (!whole) return std::nullopt;
    return from_message(decode_message<images_t>(whole->bytes.data(), whole->bytes.size()));
  }

  /// Counts frames and odometry, and finds the first calibration.
  void scan() {
    while (const auto event = log_.next_view()) {
      for (const char* channel : {"ENCODERS", "TWIST", "POSE_BODY", "ODOMETRY"})
        if (event->channel == channel) ++odometry_[channel];
      frames_ += event->channel == "CAMERA" || (is_piece(*event) && is_first(*event)) ? 1 : 0;
      if (calibration_ || event->channel != "CAMERA_CALIBRATION") continue;
      try {
        calibration_ = from_message(decode_message<camera_calibration_t>(event->data, event->size));
      } catch (const DecodeError&) {  // the next one will do: they are all alike
      }
    }
    if (!calibration_) throw std::runtime_error(file_ + ": has no CAMERA_CALIBRATION that decodes");
    log_.rewind();
  }

  std::string file_;
  LogReader log_;
  PartAssembler assembler_;
  std::optional<RgbdCalibration> calibration_;
  std::size_t frames_ = 0, malformed_ = 0;
  std::map<std::string, std::size_t> odometry_;  // messages, by channel
};

}  // namespace

std::unique_ptr<CameraSource> open_log(const std::string& file) {
  return std::make_unique<LogSource>(file);
}

LogCounts write_log(CameraSource& source, const std::string& file,
                    const std::function<void()>& before_event) {
  LogCounts counts;
  LogPublisher log(file);
  Utime next_calibration = 0;
  while (const auto event = source.next()) {
    if (before_event) before_event();
    const Utime now = event_utime(*event);
    if (now >= next_calibration) {
      camera_calibration_t calibration = to_message(source.calibration());
      calibration.utime = now;
      log.publish("CAMERA_CALIBRATION", calibration);
      next_calibration = now + calibration_period;
    }
    publish_event(log, *event);
    counts.frames += std::holds_alternative<EncodedFrame>(*event) ? 1 : 0;
    counts.encoders += std::holds_alternative<Encoders>(*event) ? 1 : 0;
    counts.truths += std::holds_alternative<GroundTruth>(*event) ? 1 : 0;
  }
  counts.bytes = log.bytes();
  if (counts.frames == 0) {
    const auto warnings = source.warnings();
    throw std::runtime_error(file + ": is not written, no frame could be read" +
                             (warnings.empty() ? "" : ": " + warnings.front()));
  }
  log.close();
  return counts;
}

}  // namespace lcmslam
