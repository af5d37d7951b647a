#include "tools/doctor/clock_checks.hpp"

#include <fmt/format.h>
#include <chrono>
#include <cmath>
#include <set>

#include <lcmslam/features_t.hpp>
#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/messages/parts.hpp>
#include <lcmslam/odometry/camera_turn.hpp>
#include <lcmslam/odometry/external_odometry.hpp>
#include <lcmslam/odometry/odometry_clock.hpp>
#include <lcmslam/odometry/twist_odometry.hpp>
#include <lcmslam/odometry/wheel_odometry.hpp>
#include <lcmslam/odometry_t.hpp>
#include <lcmslam/pose_t.hpp>
#include <lcmslam/rgbd/describe_frame.hpp>
#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/surf/surf.hpp>

namespace lcmslam {
namespace {

using Level = Finding::Level;

constexpr double noticeable = 0.005;  // s: at 60 degrees/s a third of a degree

/// Makes the camera's and odometry's paths of messages.
class ClockWatch {
 public:
  /// `motion`: the channel that odometry is taken from.
  ClockWatch(std::string motion, bool features) : motion_(std::move(motion)), features_(features) {}

  void take(const std::string& channel, const std::uint8_t* data, std::size_t size) {
    try {
      if (channel == motion_)
        take_motion(data, size);
      else if (features_ && channel == "FEATURES")
        take_features(from_message(decode_message<features_t>(data, size)));
      else if (!features_ && channel == "CAMERA_CALIBRATION")
        take_calibration(decode_message<camera_calibration_t>(data, size));
      else if (!features_ && channel == "CAMERA" && registration_)
        take_images(decode_message<images_t>(data, size));
    } catch (const DecodeError&) {
      ++malformed_;
    } catch (const std::invalid_argument&) {  // wheels that say nothing
      ++malformed_;
    }
  }

  Finding finding() const {
    Finding finding{Level::note, "odometry's clock", "", ""};
    const OdometryClock::Offset found = clock_.estimate();
    if (!found.known) {
      finding.text = "is not measured: " + found.reason;
    } else {
      finding.text =
          fmt::format("{} is {:+.1f} ms off the camera's clock (sigma {:.1f} ms, {} steps, likeness {:.2f})",
                      motion_, 1e3 * found.offset, 1e3 * found.sigma, found.steps, found.likeness);
      const bool off = std::abs(found.offset) > noticeable && std::abs(found.offset) > 3 * found.sigma;
      finding.level = off ? Level::warning : Level::good;
      if (off && motion_ == "ODOMETRY")
        finding.text += fmt::format("; add {:.4f} to the setting odometry.clock_offset", found.offset);
      else if (off)
        finding.text += fmt::format("; set odometry.clock_offset: {:.4f}", found.offset);
    }
    if (malformed_ > 0) finding.text += fmt::format("; {} messages were malformed", malformed_);
    return finding;
  }

 private:
  void take_motion(const std::uint8_t* data, std::size_t size) {
    std::optional<MotionSample> sample;
    if (motion_ == "ENCODERS") sample = wheels_.update(from_message(decode_message<encoders_t>(data, size)));
    if (motion_ == "TWIST") sample = twist_.update(from_message(decode_message<twist_t>(data, size)));
    if (motion_ == "POSE_BODY") {
      const auto message = decode_message<pose_t>(data, size);
      sample = external_.update(message.utime, from_message(message));
    }
    if (motion_ == "ODOMETRY") {
      const auto message = decode_message<odometry_t>(data, size);
      if (message.source != "visual")
        sample = from_message(message);  // visual odometry has the camera's own clock
    }
    if (sample) clock_.add_odometry(*sample);
  }

  void take_features(const FeatureFrame& frame) {
    if (const auto step = turns_.add(frame)) clock_.add_camera_step(step->from, step->to, step->turn);
  }

  void take_calibration(const camera_calibration_t& message) {
    if (!registration_) registration_.emplace(from_message(message));
  }

  void take_images(const images_t& message) {
    const RgbdFrame frame = decode_images(message, registration_->calibration());
    if (frame.colour.empty() || frame.depth.empty()) return;
    take_features(describe_frame(frame, *registration_, Eigen::Isometry3d::Identity(), surf_));
  }

  std::string motion_;
  bool features_;  // come as FEATURES; else they are made of CAMERA
  std::optional<DepthRegistration> registration_;
  Surf surf_;
  CameraTurn turns_;
  WheelOdometry wheels_;
  TwistOdometry twist_;
  ExternalOdometry external_;
  OdometryClock clock_;
  int malformed_ = 0;
};

}  // namespace

Finding check_odometry_clock(const std::string& log) {
  std::set<std::string> channels;
  LogReader reader(log);
  while (const auto event = reader.next_view()) channels.emplace(event->channel);
  reader.rewind();
  for (const char* motion : {"ENCODERS", "TWIST", "POSE_BODY", "ODOMETRY"}) {
    if (channels.count(motion) == 0) continue;
    ClockWatch watch(motion, channels.count("FEATURES") > 0);
    PartAssembler parts;
    while (const auto event = reader.next_view()) {
      if (event->channel != part_channel("CAMERA")) {
        watch.take(std::string(event->channel), event->data, event->size);
        continue;
      }
      try {
        if (const auto whole = parts.add(decode_message<part_t>(event->data, event->size)))
          watch.take("CAMERA", whole->bytes.data(), whole->bytes.size());
      } catch (const DecodeError&) {
        continue;
      }
    }
    return watch.finding();
  }
  return {Level::note, "odometry's clock",
          log + " has no ENCODERS, TWIST, POSE_BODY or ODOMETRY to compare the camera with", ""};
}

Finding check_odometry_clock_live(const std::string& lcm_url, double seconds) {
  using Clock = std::chrono::steady_clock;
  LcmBus bus(lcm_url);
  if (!bus.usable()) return {Level::failure, "odometry's clock", "LCM cannot use " + lcm_url, ""};
  ClockWatch watch("ODOMETRY", true);
  const auto reader = bus.listen(ChannelSet::matching("FEATURES|ODOMETRY"));
  const Clock::time_point end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  BusMessage message;
  while (Clock::now() < end)
    if (reader->read(message, std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now())))
      watch.take(message.channel, message.bytes.data(), message.bytes.size());
  return watch.finding();
}

}  // namespace lcmslam
