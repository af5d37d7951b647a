#pragma once
#include "camera/camera_source.hpp"
#include "runtime/publisher.hpp"

namespace lcmslam {

/// CAMERA, ENCODERS or GROUND_TRUTH, as the event is.
void publish_event(Publisher& publisher, const CameraEvent& event);

}  // namespace lcmslam
