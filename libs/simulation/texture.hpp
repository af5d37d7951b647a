#pragma once
// A repeating picture on a surface, with what the ToF camera's infrared light sees of it.

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace lcmslam {

class Texture {
 public:
  /// `bgri`: CV_8UC4, blue, green, red and infrared reflectivity, 255 = 1.
  /// `size`: metres that the picture covers before it repeats.
  Texture(const cv::Mat& bgri, const Eigen::Vector2f& size);

  /// Reflectivities (0..255) at a position in metres, averaged over about `footprint` metres
  /// (bilinear in the two nearest levels of the pyramid).
  cv::Vec4f sample(const Eigen::Vector2f& position, float footprint) const;

  const Eigen::Vector2f& size() const { return size_; }
  const cv::Mat& image() const { return levels_.front(); }

 private:
  cv::Vec4f bilinear(std::size_t level, const Eigen::Vector2f& position) const;

  Eigen::Vector2f size_;
  float texel_;  ///< m, of level 0
  std::vector<cv::Mat> levels_;
};

}  // namespace lcmslam
