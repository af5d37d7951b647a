#pragma once
// What a depth camera errs by in a way that is always the same, and depth images without it.
//
// A time-of-flight camera's modulated light is no pure sine, which gives its ranges a wiggle (Lindner et al.
// 2010, "Time-of-flight sensor calibration for accurate range sensing"):
//   measured = r + offset + scale r + wiggle sin(2 pi r / period + phase),   r the true range along the ray,
//   m.
//
// A structured-light or stereo camera measures inverse depth. Its projector or second eye, turned by a
// fraction of a pixel since it was calibrated, tilts all that it sees, the farther the more, and planes stay
// planes:
//   1 / measured z = 1 / z + tilt_x x + tilt_y y,   (x, y, 1) the pixel's ray
// which comes after the error of the range.

#include <opencv2/core.hpp>

#include <lcmslam/imaging/camera_model.hpp>

namespace lcmslam {

struct DepthError {
  double offset = 0;              ///< m
  double scale = 0;               ///< ratio
  double wiggle = 0;              ///< m
  double period = 1;              ///< m
  double phase = 0;               ///< rad
  double tilt_x = 0, tilt_y = 0;  ///< 1/m

  bool has_range_error() const { return offset != 0 || scale != 0 || wiggle != 0; }
  bool has_tilt() const { return tilt_x != 0 || tilt_y != 0; }
  bool is_zero() const { return !has_range_error() && !has_tilt(); }
  /// Measured less true range, at a true one, m.
  double at(double range) const;
  /// The true range of a measured one, m.
  double corrected(double measured) const;

  void check() const;  ///< throws std::invalid_argument naming the wrong value
  bool operator==(const DepthError& other) const;
};

/// Takes the error out of depth images; keeps the tables that depend on camera and error alone.
class DepthCorrector {
 public:
  DepthCorrector(const CameraModel& camera, const DepthError& error);

  /// CV_16UC1 millimetres along the optical axis of the camera's size, corrected in place; 0 stays 0. Throws
  /// std::invalid_argument for another image.
  void operator()(cv::Mat& depth) const;

 private:
  cv::Mat stretch_;  // CV_32FC1: range over depth, of each pixel
  cv::Mat tilt_;     // CV_32FC1, 1/mm: what inverse depth is off by, of each pixel
  std::vector<float>
      factors_;  // true over measured range, by the measured one in steps; none: the tilt is all
};

}  // namespace lcmslam
