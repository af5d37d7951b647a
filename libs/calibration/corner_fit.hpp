#pragma once
// Where two edges of a checkerboard cross, from the grey values around: a model of the image is fitted to all
// of them. A few pixels that see a corner tell it to a hundredth of their size; gradients (cv::cornerSubPix)
// of so few tell it five times less well.

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

namespace lcmslam {

/// `grey`: CV_8UC1. `start`: to about a pixel. `edges`: direction of each, in columns; where the corner is to
/// be looked at, out to `radius` pixels, there is nothing else. Nothing where the image shows something else.
std::optional<Eigen::Vector2d> fit_corner(const cv::Mat& grey, const Eigen::Vector2d& start,
                                          const Eigen::Matrix2d& edges, double radius);

}  // namespace lcmslam
