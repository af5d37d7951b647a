#pragma once
// Where the texture around a pixel of one image lies in another. A blob's middle depends on how slanted and
// how near it is seen; the texture around it does not: a detector's pixel errs by a third of a pixel, an
// alignment by a tenth.

#include <opencv2/core.hpp>
#include <optional>

#include <Eigen/Core>

namespace lcmslam {

/// From offsets to a middle: A x + t + bend (x^2, xy, y^2).
struct PatchWarp {
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
  Eigen::Vector2d t = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> bend = Eigen::Matrix<double, 2, 3>::Zero();

  Eigen::Vector2d operator()(double x, double y) const {
    return A * Eigen::Vector2d(x, y) + t + bend * Eigen::Vector3d(x * x, x * y, y * y);
  }
};

struct PatchAlignmentSettings {
  int iterations = 20;
  double converged = 0.02;      ///< pixels, of a step
  double farthest = 4;          ///< pixels from where it began
  double least_contrast = 4;    ///< grey values, standard deviation in the patch
  double least_likeness = 0.9;  ///< correlation of both patches
};

/// `reference` and `image` are CV_8UC1; `radius`: of the square patch around `at`. `start` takes offsets in
/// the reference to pixels of the image; its bend stays. Nothing where the texture is too poor, elsewhere, or
/// not alike.
std::optional<PatchWarp> align_patch(const cv::Mat& reference, const Eigen::Vector2d& at, int radius,
                                     const cv::Mat& image, const PatchWarp& start,
                                     const PatchAlignmentSettings& settings = {});

}  // namespace lcmslam
