#pragma once
#include <lcmslam/runtime/publisher.hpp>
#include "procs/camera/camera_source.hpp"

namespace lcmslam {

/// CAMERA, ENCODERS or GROUND_TRUTH, as the event is.
void publish_event(Publisher& publisher, const CameraEvent& event);

}  // namespace lcmslam
