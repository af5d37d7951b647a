#pragma once
#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>

namespace lcmslam {

/// As it goes out. A camera without depth gets a depth image that measured nothing, one without colour a
/// black colour image: consumers know no other shots.
EncodedFrame encode_shot(RgbdFrame frame, const RgbdCalibration& calibration, int jpeg_quality);

}  // namespace lcmslam
