#pragma once
#include <functional>

#include "procs/camera/camera_source.hpp"

namespace lcmslam {

/// A source several times over, each pass's times shifted on behind the last one's by the usual distance of
/// two frames: for endurance tests with a short recording. `open` opens the source anew.
std::unique_ptr<CameraSource> repeat_source(std::function<std::unique_ptr<CameraSource>()> open, int passes);

}  // namespace lcmslam
