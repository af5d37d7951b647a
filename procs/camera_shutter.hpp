#pragma once
// How long the camera in use reads the rows of an image, as CAMERA_CALIBRATION tells it to those who get
// FEATURES.

#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/runtime/stamp_judge.hpp>

namespace lcmslam {

class CameraShutter {
 public:
  /// Throws DecodeError for what is no calibration.
  void hear(const camera_calibration_t& message, const StampJudge& stamps) {
    if (sender_ && is_of_another_camera(message.sender, *sender_, stamps)) return;
    seconds_ = from_message(message).rolling_shutter;
    sender_ = message.sender;
  }
  /// From the first row to the last; 0: all at once, or not known.
  double seconds() const { return seconds_; }

 private:
  double seconds_ = 0;
  std::optional<std::int64_t> sender_;
};

}  // namespace lcmslam
