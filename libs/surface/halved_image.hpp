#pragma once
// Images of half the size, for depth cameras whose pixels are finer than voxels.

#include <opencv2/core.hpp>

namespace lcmslam {

/// CV_16UC1 mm, 0 = invalid. The mean of what belongs to the nearest of each two by two pixels: a mean over
/// an edge would be a place of its own. The last row or column of an odd number is left out.
cv::Mat halved_depth(const cv::Mat& depth);

}  // namespace lcmslam
