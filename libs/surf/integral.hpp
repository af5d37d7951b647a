#pragma once
// Summed-area table: the sum over any upright box from four numbers (Viola & Jones 2001).

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace lcmslam {

/// row(y)[x] is the sum of all pixels above row y and left of column x, modulo 2^32: differences are
/// right for every box whose own sum is below 2^31, whatever the size of the image.
class IntegralImage {
 public:
  /// From an 8-bit, one-channel image. Reuses its memory from call to call.
  void compute(const cv::Mat& grey);

  /// Of the image of half the size whose pixels are the sums of 2 x 2 of the finer one's. An odd last
  /// row or column is left out.
  void halve(const IntegralImage& finer);

  int width() const { return width_; }    ///< of the image; a row here has one more
  int height() const { return height_; }  ///< of the image; there is one row more here
  const std::uint32_t* row(int y) const {
    return sums_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_ + 1);
  }

  /// Sum over the pixels x0 <= x < x1, y0 <= y < y1.
  std::int32_t box(int x0, int y0, int x1, int y1) const {
    const std::uint32_t* top = row(y0);
    const std::uint32_t* bottom = row(y1);
    return static_cast<std::int32_t>((bottom[x1] - bottom[x0]) - (top[x1] - top[x0]));
  }

 private:
  void resize(int width, int height);

  int width_ = 0, height_ = 0;
  std::vector<std::uint32_t> sums_;
};

}  // namespace lcmslam
