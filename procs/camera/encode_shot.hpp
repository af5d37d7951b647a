#pragma once
#include <lcmslam/cameras/camera_shot.hpp>
#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>

namespace lcmslam {

/// As it goes out, a camera's JPEG as it came. A camera without depth gets a depth image that measured
/// nothing, one without colour a black colour image: consumers know no other shots.
EncodedFrame encode_shot(CameraShot frame, const RgbdCalibration& calibration, int jpeg_quality);

}  // namespace lcmslam
