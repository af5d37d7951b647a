#pragma once
#include "procs/camera/camera_source.hpp"

namespace lcmslam {

/// make_camera_source with cameras too: for the camera process, as the drivers' libraries take a while to
/// load. Throws CameraError when the build lacks a driver, or a recording cannot be opened; a camera may come
/// later.
std::unique_ptr<CameraSource> make_source_or_device(const CameraSettings& settings);

}  // namespace lcmslam
