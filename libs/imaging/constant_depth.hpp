#pragma once
// A depth image that has one value everywhere is what a driver gives that has no data: every sensor's noise
// and quantisation tell neighbouring pixels apart, before a bare wall too.

#include <opencv2/core.hpp>

namespace lcmslam {

/// Whether all valid pixels (not 0) of a CV_16UC1 image have one value, and most pixels are valid. An image
/// of a surface costs a few comparisons.
bool is_constant_depth(const cv::Mat& depth);

}  // namespace lcmslam
