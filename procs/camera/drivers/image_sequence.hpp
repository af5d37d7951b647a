#pragma once
#include <memory>

#include <lcmslam/cameras/camera_device.hpp>
#include "procs/camera/drivers/driver_settings.hpp"

namespace lcmslam {

/// Images whose names have their number in them, `left/%06d.png`, as a camera. A number counts an interval of
/// `rate`, also one that is missing: of these the log tells. Throws CameraError.
std::unique_ptr<CameraDevice> open_sequence(const VideoSettings& settings);

}  // namespace lcmslam
