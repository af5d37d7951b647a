#pragma once
// What the colour camera sees where the depth camera's rays end.

#include <opencv2/core.hpp>

#include <lcmslam/surface/lens.hpp>

namespace lcmslam {

/// `points` CV_32FC3 in the colour camera's frame (m, NaN: none), `colour` CV_8UC3 of the lens's size. Fills
/// `found` (CV_8UC3) and `seen` (CV_8UC1, 255) of the points' size where no other point hides the place from
/// the colour camera. `footprint`: colour pixels between neighbouring points.
void look_up_colours(const cv::Mat& points, const cv::Mat& colour, const Lens& lens, float footprint,
                     cv::Mat& found, cv::Mat& seen);

}  // namespace lcmslam
