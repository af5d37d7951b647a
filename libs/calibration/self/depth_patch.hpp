#pragma once
#include <opencv2/core.hpp>
#include <optional>

#include <lcmslam/calibration/self/residuals.hpp>
#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam {

/// The surface around a pixel of a depth image (CV_32FC1, 1/m, 0 = none): its inverse depth there, where it
/// may be bent a little, and its slope. Nothing at depth edges, at steep surfaces, beside holes and at the
/// image's rim.
std::optional<residuals::Patch> depth_patch(const cv::Mat& inverse_depth, const Eigen::Vector2d& pixel,
                                            const CameraModel& camera, const DepthNoise& noise);

}  // namespace lcmslam
