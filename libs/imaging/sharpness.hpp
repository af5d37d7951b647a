#pragma once
// How sharp an image is, and whether it is less so than its predecessors: motion blur shows in that.

#include <opencv2/core.hpp>

namespace lcmslam {

/// Mean absolute horizontal gradient, grey values a pixel, of every fourth row. CV_8UC1; 0 for less than
/// two columns.
float sharpness(const cv::Mat& grey);

/// Compares each image with the usual sharpness of the scene.
class SharpnessWatch {
 public:
  /// Returns true when the image is blurred: less than 0.6 times as sharp as usual.
  bool observe(float sharpness);

  /// Running mean over about 30 images; blurred ones weigh less, so that a long shake is still noticed.
  float usual() const { return usual_; }

 private:
  float usual_ = 0;
};

}  // namespace lcmslam
