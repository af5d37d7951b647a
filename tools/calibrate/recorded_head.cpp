#include "tools/calibrate/recorded_head.hpp"

#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/odometry/wheel_odometry.hpp>
#include "tools/calibrate/recorded_drive.hpp"
#include "tools/log/message_reader.hpp"
#include "tools/output_file.hpp"

namespace lcmslam {
namespace {

double seconds(Utime from, Utime to) {
  return 1e-6 * static_cast<double>(to - from);
}

class HeadReader {
 public:
  HeadReader(const RgbdCalibration& start, const RecordedHeadOptions& options, bool encoders)
      : options_(options), encoders_(encoders) {
    head.start = start;
    head.scene = std::make_unique<RecordedScene>(start, RecordedSceneSettings{});
  }

  /// False where the part of the log that counts is over.
  bool take(const LogEventView& event) {
    try {
      if (event.channel == "CAMERA") return take(decode_message<images_t>(event.data, event.size));
      if (event.channel == "ENCODERS") {
        if (const auto sample =
                wheels_.update(from_message(decode_message<encoders_t>(event.data, event.size))))
          head.scene->add(*sample);
      } else if (event.channel == "ODOMETRY" && !encoders_) {
        const auto message = decode_message<odometry_t>(event.data, event.size);
        if (message.source != "visual") head.scene->add(from_message(message));
      }
    } catch (const DecodeError& error) {
      if (head.damaged++ == 0) first_damage = error.what();
    } catch (const std::invalid_argument&) {  // wheels that say nothing
      ++head.damaged;
    }
    return true;
  }

  RecordedHead head;
  std::string first_damage;  // what was wrong with the first message that could not be read

 private:
  bool take(const images_t& message) {
    if (first_ == 0) first_ = message.utime;
    if (options_.seconds > 0 && seconds(first_, message.utime) > options_.seconds) return false;
    // A camera's period is not exact.
    if (options_.rate > 0 && last_ != 0 && seconds(last_, message.utime) < 0.75 / options_.rate) return true;
    last_ = message.utime;
    head.scene->add(decode_images(message, head.start));
    return true;
  }

  RecordedHeadOptions options_;
  bool encoders_;
  WheelOdometry wheels_;
  Utime first_ = 0, last_ = 0;
};

}  // namespace

RecordedHead read_head(const std::string& log, const std::optional<RgbdCalibration>& given,
                       const RecordedHeadOptions& options) {
  const auto start = given ? given : calibration_in(log);
  if (!start)
    throw std::runtime_error(log + ": has no CAMERA_CALIBRATION to begin with: give one with --into");
  HeadReader head(*start, options, scan_log(log).channels.count("ENCODERS") > 0);
  MessageReader reader(log);
  while (const auto event = reader.next()) {
    throw_when_stopped();
    if (!head.take(*event)) break;
  }
  if (head.head.scene->frames() == 0)
    throw std::runtime_error(log + ": no image of CAMERA in it can be read" +
                             (head.head.damaged > 0 ? " by this calibration: " + head.first_damage : ""));
  return std::move(head.head);
}

}  // namespace lcmslam
