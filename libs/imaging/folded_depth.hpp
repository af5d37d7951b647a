#pragma once
// A time-of-flight camera of one frequency measures what is a turn of its phase farther that turn too near: a
// wall at 9.5 m stands at 2 m. Cameras correct the amplitude by the range that they measured, so a folded
// surface looks darker than it is, by (r / (r + turn))^2 of the range measured. No surface is brighter than
// white: what is brighter than that share of white was measured right, what is not may be folded. (Amplitude
// tells the turn: Choi et al. 2010, "Range unfolding for time-of-flight depth cameras".)
//
// That takes the depth of what is really dark or seen at a grazing angle, too, but there noise has left
// little in it.

#include <opencv2/core.hpp>

#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam {

class FoldedDepthFilter {
 public:
  /// The turn is the calibration's depth_max, if its depth has amplitude noise; other cameras do not fold.
  explicit FoldedDepthFilter(const RgbdCalibration& calibration);

  /// Sets pixels that may be folded to 0. `depth` CV_16UC1 mm of the calibration's size, `amplitude` CV_8UC1
  /// of the same size, 255 for white at a right angle; one that is empty leaves the depth as it is. Throws
  /// std::invalid_argument for other images.
  void operator()(cv::Mat& depth, const cv::Mat& amplitude) const;

 private:
  float turn_ = 0;   // mm; 0: does not fold
  cv::Mat stretch_;  // CV_32FC1: range over depth, of each pixel
};

}  // namespace lcmslam
