#pragma once
// What registering a depth image takes of it, without an image of all its points.

#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/imaging/depth_rows.hpp>

namespace lcmslam {

/// Every `step`-th row and column of a point image, with normals.
struct ThinnedDepth {
  cv::Mat points;   ///< CV_32FC3, ceil(rows / step) x ceil(cols / step), m, NaN where invalid
  cv::Mat sigma;    ///< CV_32FC1, likewise
  cv::Mat normals;  ///< CV_32FC3, as estimate_normals() gives them
  int step = 1;
  int rows = 0;     ///< of the whole image
  float pitch = 0;  ///< of the whole image's pixels, rad
};

/// Gives pieces of DepthRegistration::unproject(frame), bit for bit.
class DepthPoints {
 public:
  /// `calibration` as DepthRegistration has it: the depth camera is the colour camera where depth is
  /// registered.
  explicit DepthPoints(const RgbdCalibration& calibration);

  /// `columns` points (x, y, z one after the other) and sigmas from pixel (first, row) on. The frame must
  /// pass check_frame() and have depth.
  void row(const RgbdFrame& frame, int row, int first, int columns, float* points, float* sigma) const;
  /// Throws std::invalid_argument when the frame is not of the calibration's size.
  ThinnedDepth thinned(const RgbdFrame& frame, int step) const;

  const RgbdCalibration& calibration() const { return calibration_; }

 private:
  RgbdCalibration calibration_;
  DepthRowGeometry geometry_;
  bool moves_;    // the colour camera is not the depth camera
  cv::Mat rays_;  // of the depth camera, CV_32FC2
};

}  // namespace lcmslam
