#pragma once
// What a calibration's report shows besides numbers.

#include <lcmslam/calibration/camera_calibration.hpp>

namespace lcmslam {

/// Where in the image corners were seen, a colour a view, the boards outlined. CV_8UC3.
cv::Mat coverage_picture(const CameraCalibration& calibration, const Board& board);

/// How far each corner lies from where the calibration puts it, as an arrow a hundred times as long. Arrows
/// that agree with their neighbours are a lens that the model does not describe; arrows in all directions are
/// noise. CV_8UC3.
cv::Mat residual_picture(const CameraCalibration& calibration);

}  // namespace lcmslam
