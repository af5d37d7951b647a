#include "log_writer.hpp"

#include <filesystem>
#include <lcm/lcm-cpp.hpp>

#include "camera/publish_event.hpp"
#include "messages/camera_messages.hpp"
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

}  // namespace

LogCounts write_log(CameraSource& source, const std::string& file) {
  const std::string part = file + ".part";
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
  std::filesystem::rename(part, file);
  return counts;
}

}  // namespace lcmslam
