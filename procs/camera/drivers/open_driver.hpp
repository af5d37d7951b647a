#pragma once
// One camera, by any of the drivers that this build has.

#include <memory>

#include <lcmslam/cameras/camera_device.hpp>
#include "procs/camera/drivers/driver_settings.hpp"

namespace lcmslam {

/// What is wanted of a camera that has both images.
struct WantedImages {
  bool colour = true, depth = true;
  bool registered = false;  ///< depth pixel (u, v) shall belong to colour pixel (u, v)
  Utime depth_offset = 0;   ///< us, added to depth's stamps gives colour's clock: pairs are made by that
};

/// The driver is not part of this build; says what to install.
class DriverMissing : public CameraError {
 public:
  using CameraError::CameraError;
};

/// Each throws CameraError.
std::unique_ptr<CameraDevice> open_driver(const DriverSettings& settings, const WantedImages& wanted);
std::unique_ptr<CameraDevice> open_video(const VideoSettings& settings);
std::unique_ptr<CameraDevice> open_openni2(const OpenNi2Settings& settings, const WantedImages& wanted);
std::unique_ptr<CameraDevice> open_freenect(const FreenectSettings& settings, const WantedImages& wanted);

/// Throws DriverMissing, without looking for the camera, when this build lacks the driver.
void require_driver(const std::string& driver);
extern const bool has_openni2, has_freenect;

}  // namespace lcmslam
