#pragma once
// A camera that may be unplugged, stall, send what it should not, and come back.
//
// It is opened, read and, when it gives nothing more, closed and opened again, with pauses that double while
// it stays away. Whoever reads it calls step() over and over, in a thread of the camera's own (drivers
// block); health() may be asked by any thread, also while step() hangs in a driver.

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

#include <lcmslam/cameras/camera_device.hpp>
#include <lcmslam/cameras/expected_images.hpp>
#include <lcmslam/cameras/frame_gaps.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct WatchSettings {
  double late_after = 0.5;
  double reopen_after = 3;
  double retry_after = 0.5;
  double retry_at_most = 10;

  void describe(SettingsVisitor& s);
};

struct CameraHealth {
  bool open = false;
  bool silent = true;        ///< not open, or without a good image for longer than late_after
  std::string trouble;       ///< in words; empty: none
  std::int64_t images = 0;   ///< shots that were good
  std::int64_t dropped = 0;  ///< that the camera left out, by the stamps
  std::int64_t refused = 0;  ///< of a wrong size, or not later than the one before
  std::int64_t opened = 0;   ///< times that it could be opened
  std::int64_t opening = 0;  ///< times that it was tried
};

class WatchedCamera {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Clock = std::function<Time()>;

  WatchedCamera(OpenCamera open, const ExpectedImages& expected, const WatchSettings& settings,
                Clock clock = std::chrono::steady_clock::now);

  struct Step {
    std::optional<CameraShot> frame;  ///< good images
    std::chrono::milliseconds wait{
        0};  ///< until step() has something to do; the caller may be stopped meanwhile
  };
  /// Opens the camera if it is time to, else waits a tenth of a second at most for its images. Throws
  /// nothing.
  Step step();

  CameraHealth health() const;
  /// What was opened last (CameraDevice::describe); empty before.
  std::string description() const;

 private:
  void open();
  void close(const std::string& why);
  void close_if_silent();
  std::optional<CameraShot> check(CameraShot frame);
  std::string what_is_wrong(const CameraShot& frame) const;
  std::chrono::duration<double> pause() const;

  OpenCamera open_;
  ExpectedImages expected_;
  WatchSettings settings_;
  Clock clock_;
  std::unique_ptr<CameraDevice> device_;
  FrameGaps gaps_;
  Utime last_utime_ = 0;

  mutable std::mutex mutex_;  // guards what follows; the camera is opened and read without
  CameraHealth health_;
  std::string description_;
  std::string why_closed_, misfit_;
  int failures_ = 0;  // since the last good image
  Time last_good_{};  // or opened
  std::optional<Time> opening_since_;
  Time next_opening_{};
};

}  // namespace lcmslam
