#pragma once
// Another driver's images: whether they are of the calibration, and what goes on as CAMERA.

#include <chrono>
#include <functional>

#include <lcmslam/cameras/frame_gaps.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include "procs/camera/camera_source.hpp"

namespace lcmslam {

class ForeignImages {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Clock = std::function<Time()>;

  ForeignImages(std::string channel, const RgbdCalibration& calibration, const LiveSettings& settings,
                Clock clock = std::chrono::steady_clock::now);

  /// What goes out: raw colour as JPEG and raw depth zipped, so that it stays small, the sensor's name, and
  /// stamps where the driver gave none. Nothing when the message is no shot of this camera; that is counted.
  std::optional<EncodedFrame> relay(const images_t& message);

  SourceHealth health() const;

 private:
  std::string channel_;
  const RgbdCalibration& calibration_;
  LiveSettings settings_;
  Clock clock_;
  Time last_;  // good images; at first the start
  Utime last_utime_ = 0;
  FrameGaps gaps_;
  std::string misfit_;
  std::int64_t relayed_ = 0, refused_ = 0, dropped_ = 0;
};

}  // namespace lcmslam
