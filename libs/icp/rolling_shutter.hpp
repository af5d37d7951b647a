#pragma once
// Rows of an image are read one after the other; a camera that turns meanwhile sees a sheared world (at
// 100 degrees/s and 30 ms, 3 degrees from the first row to the last). Points go back to where they were in
// the middle of the image.

#include <opencv2/core.hpp>

#include "surf/feature.hpp"

namespace lcmslam {

/// `points`: CV_32FC3, rows as they were read, camera frame; `motion`: the camera's twist (its own frame)
/// from the first row to the last.
void straighten_rows(cv::Mat& points, const Vector6d& motion);

/// The same for the points of features, by the rows where they were seen.
void straighten_rows(FeatureFrame& features, const Vector6d& motion);

}  // namespace lcmslam
