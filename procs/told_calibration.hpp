#pragma once
// What CAMERA_CALIBRATION tells a process, also where the log is older than what is told today.

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/runtime/stamp_judge.hpp>

namespace lcmslam {

/// Logs from before calibrations told their rolling shutter know it by the sensor's name. Throws DecodeError
/// for what is no calibration.
inline RgbdCalibration told_calibration(const camera_calibration_t& message) {
  RgbdCalibration calibration = from_message(message);
  if (tells_rolling_shutter(message)) return calibration;
  if (const auto known = find_calibration(calibration.sensor, share_path("config/calibration")))
    calibration.rolling_shutter = known->rolling_shutter;
  return calibration;
}

/// How long the camera in use reads the rows of an image, for those who get FEATURES.
class CameraShutter {
 public:
  /// Throws DecodeError, likewise.
  void hear(const camera_calibration_t& message, const StampJudge& stamps) {
    if (known_ && is_of_another_camera(message.sender, known_->sender, stamps)) return;
    if (!known_ || !same_calibration(message, *known_)) seconds_ = told_calibration(message).rolling_shutter;
    known_ = message;
  }
  /// From the first row to the last; 0: all at once, or not known.
  double seconds() const { return seconds_; }

 private:
  double seconds_ = 0;
  std::optional<camera_calibration_t> known_;
};

}  // namespace lcmslam
