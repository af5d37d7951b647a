#pragma once
// Rows of an image are read one after the other; a camera that turns meanwhile sees a sheared world (at
// 100 degrees/s and 30 ms, 3 degrees from the first row to the last). Points go back to where they were in
// the middle of the image.

#include <opencv2/core.hpp>

#include <lcmslam/features/feature.hpp>

namespace lcmslam {

/// From the camera at a row to the camera at the middle of the image. `motion`: the camera's twist (its own
/// frame) from the first row to the last.
Eigen::Isometry3f row_transform(double row, int rows, const Vector6d& motion);

/// `points`: CV_32FC3, rows as they were read, camera frame.
void straighten_rows(cv::Mat& points, const Vector6d& motion);

/// The same for the points of features, by the rows where they were seen.
void straighten_rows(FeatureFrame& features, const Vector6d& motion);

}  // namespace lcmslam
