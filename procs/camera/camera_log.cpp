#include "camera/camera_log.hpp"

#include <unistd.h>

#include <filesystem>
#include <lcm/lcm-cpp.hpp>

#include "camera/publish_event.hpp"
#include "messages/camera_messages.hpp"
#include "messages/decode.hpp"
#include "messages/geometry_messages.hpp"
#include "messages/motion_messages.hpp"
#include "runtime/publisher.hpp"

namespace lcmslam {
namespace {

constexpr Utime calibration_period = 1'000'000;  // us

class LogPublisher : public Publisher {
 public:
  explicit LogPublisher(const std::string& file) : Publisher(1), file_(file), log_(file, "w") {
    if (!log_.good()) throw std::runtime_error(file + ": cannot be written");
  }
  std::int64_t bytes() const { return bytes_; }

 private:
  void send(const std::string& channel, const std::vector<std::uint8_t>& data, Utime utime) override {
    std::vector<std::uint8_t> copy = data;  // LCM's event wants it writable
    lcm::LogEvent event;
    event.eventnum = 0;
    event.channel = channel;
    event.timestamp = utime;
    event.datalen = static_cast<int32_t>(copy.size());
    event.data = copy.data();
    if (log_.writeEvent(&event) != 0) throw std::runtime_error(file_ + ": writing failed (disk full?)");
    bytes_ += event.datalen;
  }

  std::string file_;
  lcm::LogFile log_;
  std::int64_t bytes_ = 0;
};

/// The event that a message stands for; nothing for channels that are not the camera's.
std::optional<CameraEvent> read_event(const lcm::LogEvent& event) {
  const auto* data = static_cast<const std::uint8_t*>(event.data);
  const auto size = static_cast<std::size_t>(event.datalen);
  if (event.channel == "CAMERA") return from_message(decode_message<images_t>(data, size));
  if (event.channel == "ENCODERS") return from_message(decode_message<encoders_t>(data, size));
  if (event.channel != "GROUND_TRUTH") return std::nullopt;
  const auto truth = decode_message<ground_truth_t>(data, size);
  return GroundTruth{truth.utime, truth.child_frame, from_message(truth.T_frame_child, "T_frame_child")};
}

class LogSource : public CameraSource {
 public:
  explicit LogSource(const std::string& file) : file_(file) {
    scan();
    log_ = std::make_unique<lcm::LogFile>(file, "r");
  }

  const RgbdCalibration& calibration() const override { return *calibration_; }
  std::size_t frames() const override { return frames_; }
  std::size_t malformed() const override { return malformed_; }
  std::vector<std::string> notes() const override {
    return {file_ + ": " + std::to_string(frames_) + " frames"};
  }

  std::optional<CameraEvent> next() override {
    while (const lcm::LogEvent* event = log_->readNextEvent()) {
      try {
        if (auto read = read_event(*event)) return read;
      } catch (const DecodeError&) {
        ++malformed_;
      }
    }
    return std::nullopt;
  }

 private:
  /// Counts the frames and finds the first calibration.
  void scan() {
    lcm::LogFile log(file_, "r");
    if (!log.good()) throw std::runtime_error(file_ + ": cannot be opened as an LCM log");
    while (const lcm::LogEvent* event = log.readNextEvent()) {
      frames_ += event->channel == "CAMERA" ? 1 : 0;
      if (calibration_ || event->channel != "CAMERA_CALIBRATION") continue;
      calibration_ = from_message(decode_message<camera_calibration_t>(
          static_cast<const std::uint8_t*>(event->data), static_cast<std::size_t>(event->datalen)));
    }
    if (!calibration_) throw std::runtime_error(file_ + ": has no CAMERA_CALIBRATION");
  }

  std::string file_;
  std::unique_ptr<lcm::LogFile> log_;
  std::optional<RgbdCalibration> calibration_;
  std::size_t frames_ = 0, malformed_ = 0;
};

}  // namespace

std::unique_ptr<CameraSource> open_log(const std::string& file) {
  return std::make_unique<LogSource>(file);
}

LogCounts write_log(CameraSource& source, const std::string& file) {
  const std::string part = file + ".part" + std::to_string(getpid());
  LogCounts counts;
  {
    LogPublisher log(part);
    Utime next_calibration = 0;
    while (const auto event = source.next()) {
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
  }
  // The last bytes are written when the log closes, which tells no errors.
  if (std::filesystem::file_size(part) < static_cast<std::uintmax_t>(counts.bytes))
    throw std::runtime_error(part + ": is incomplete (disk full?)");
  std::filesystem::rename(part, file);
  return counts;
}

}  // namespace lcmslam
