#include "surf/integral.hpp"

namespace lcmslam {

void IntegralImage::compute(const cv::Mat& grey) {
  CV_Assert(grey.empty() || grey.type() == CV_8UC1);
  width_ = grey.cols;
  height_ = grey.rows;
  const std::size_t stride = static_cast<std::size_t>(width_) + 1;
  sums_.resize(stride * (static_cast<std::size_t>(height_) + 1));
  for (std::size_t x = 0; x < stride; ++x) sums_[x] = 0;
  for (int y = 0; y < height_; ++y) {
    const std::uint8_t* pixel = grey.ptr<std::uint8_t>(y);
    const std::uint32_t* above = row(y);
    std::uint32_t* sum = sums_.data() + static_cast<std::size_t>(y + 1) * stride;
    std::uint32_t run = 0;
    sum[0] = 0;
    for (int x = 0; x < width_; ++x) {
      run += pixel[x];
      sum[x + 1] = above[x + 1] + run;
    }
  }
}

}  // namespace lcmslam
