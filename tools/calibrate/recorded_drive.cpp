#include "tools/calibrate/recorded_drive.hpp"

#include <lcmslam/calibration/camera_tracker.hpp>
#include <lcmslam/calibration/floor_sight.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include "tools/log/message_reader.hpp"
#include "tools/output_file.hpp"

namespace lcmslam {
namespace {

class DriveReader {
 public:
  explicit DriveReader(const RgbdCalibration& calibration)
      : tracker_(calibration), floor_(calibration, calibration.T_robot_camera) {
    drive.calibration = calibration;
  }

  void take(const LogEventView& event) {
    try {
      if (event.channel == "CAMERA") take(decode_message<images_t>(event.data, event.size));
      if (event.channel == "ENCODERS")
        encoders_.push_back(from_message(decode_message<encoders_t>(event.data, event.size)));
      if (event.channel == "ODOMETRY") {
        const auto message = decode_message<odometry_t>(event.data, event.size);
        if (message.source != "visual") odometry_.push_back(from_message(message));
      }
    } catch (const DecodeError& error) {
      if (drive.damaged++ == 0) drive.first_damage = error.what();
    }
  }

  RecordedDrive finish() {
    drive.steps = encoders_.size() > 1 ? wheel_steps(encoders_) : wheel_steps(odometry_);
    if (!encoders_.empty()) drive.wheels = encoders_.back().wheels;
    drive.floor = floor_.sight();
    return std::move(drive);
  }

  RecordedDrive drive;

 private:
  void take(const images_t& message) {
    const RgbdFrame frame = decode_images(message, drive.calibration);
    ++drive.images;
    if (drive.images % 3 == 0) floor_.add(frame.depth);
    const auto sample = tracker_.add(frame);
    if (!sample) return;
    ++drive.tracked;
    drive.camera.push_back(*sample);
  }

  CameraTracker tracker_;
  FloorWatch floor_;
  std::vector<Encoders> encoders_;
  std::vector<MotionSample> odometry_;
};

}  // namespace

std::optional<RgbdCalibration> calibration_in(const std::string& log) {
  MessageReader reader(log);
  while (const auto event = reader.next())
    if (event->channel == "CAMERA_CALIBRATION")
      return from_message(decode_message<camera_calibration_t>(event->data, event->size));
  return std::nullopt;
}

RecordedDrive read_drive(const std::string& log, const std::optional<RgbdCalibration>& given) {
  const auto calibration = given ? given : calibration_in(log);
  if (!calibration)
    throw std::runtime_error(log +
                             ": it has no CAMERA_CALIBRATION: give the camera's calibration with --into");
  DriveReader drive(*calibration);
  MessageReader reader(log);
  while (const auto event = reader.next()) {
    throw_when_stopped();
    drive.take(*event);
  }
  RecordedDrive result = drive.finish();
  if (result.images == 0)
    throw std::runtime_error(log + ": no image of CAMERA in it can be read" +
                             (result.damaged > 0 ? " by this calibration: " + result.first_damage : ""));
  if (result.steps.empty())
    throw std::runtime_error(log + ": it has neither ENCODERS nor ODOMETRY of wheels");
  return result;
}

}  // namespace lcmslam
