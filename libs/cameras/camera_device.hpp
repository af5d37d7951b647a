#pragma once
// A camera as its driver gives it: opened by its constructor, closed by its destructor.

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include <lcmslam/cameras/camera_shot.hpp>

namespace lcmslam {

/// Why a camera cannot be opened or gives no more images, in words.
class CameraError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class CameraDevice {
 public:
  virtual ~CameraDevice() = default;

  /// Waits at most `patience` for the next images; nothing when none came. A camera without colour leaves the
  /// colour image empty, one without depth the depth image. Throws CameraError when the camera is gone.
  virtual std::optional<CameraShot> read(std::chrono::milliseconds patience) = 0;

  /// A recording has been read to its end: read() gives what waited for its partner, then nothing any more.
  virtual bool ended() const { return false; }

  /// What was opened, and how it was set: "/dev/video0: 640x480 MJPG, 30 Hz".
  virtual std::string describe() const = 0;
};

/// Throws CameraError.
using OpenCamera = std::function<std::unique_ptr<CameraDevice>()>;

}  // namespace lcmslam
