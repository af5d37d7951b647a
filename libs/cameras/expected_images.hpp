#pragma once
// What a camera's images must be, by its calibration.

#include <string>

#include <lcmslam/cameras/camera_shot.hpp>

namespace lcmslam {

/// A size of 0x0: any will do, and none is needed.
struct ExpectedImages {
  cv::Size colour, depth;
};

/// "the colour image is 320x240, by its calibration it must be 640x480"; empty when all is as expected.
std::string misfit(const CameraShot& frame, const ExpectedImages& expected);

}  // namespace lcmslam
