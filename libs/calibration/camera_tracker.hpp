#pragma once
// How a colour and depth camera moves, by what it sees alone: for calibrating where it sits on a robot.

#include <memory>
#include <optional>

#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>

namespace lcmslam {

class CameraTracker {
 public:
  /// The calibration's mount is not looked at. Throws std::invalid_argument for one that does not pass
  /// check().
  explicit CameraTracker(const RgbdCalibration& calibration);
  ~CameraTracker();

  /// Pose of the colour camera, T_odom_camera (the sample's T_odom_robot), at the colour image's time;
  /// nothing while it is not tracked. Frames in order of time.
  std::optional<MotionSample> add(const RgbdFrame& frame);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace lcmslam
