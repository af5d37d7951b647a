#pragma once
// Rows of an image are read one after the other; a camera that turns meanwhile sees a sheared world (at
// 100 degrees/s and 30 ms, 3 degrees from the first row to the last). Points go back to where they were in
// the middle of the image.

#include <opencv2/core.hpp>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

/// From the camera at a row to the camera at the middle of the image. `motion`: the camera's twist (its own
/// frame) from the first row to the last.
Eigen::Isometry3f row_transform(double row, int rows, const Vector6d& motion);

/// `points`: CV_32FC3, rows as they were read, camera frame.
void straighten_rows(cv::Mat& points, const Vector6d& motion);

/// The same for features, by the rows where they were seen: their points, and the pixels of those without
/// depth, which turning alone moves.
void straighten_rows(FeatureFrame& features, const Vector6d& motion);

/// The same with the robot's motion just before the image, or else as it went on last. `rolling_shutter`: s
/// from the first row to the last. Where nothing tells the motion all stays as it was read.
void straighten_rows(FeatureFrame& features, const MotionBuffer& motion, double rolling_shutter);

}  // namespace lcmslam
