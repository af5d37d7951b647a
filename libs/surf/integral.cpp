#include <lcmslam/surf/integral.hpp>

#include <algorithm>

namespace lcmslam {

void IntegralImage::resize(int width, int height) {
  width_ = width;
  height_ = height;
  sums_.resize((static_cast<std::size_t>(width) + 1) * (static_cast<std::size_t>(height) + 1));
}

void IntegralImage::compute(const cv::Mat& grey) {
  CV_Assert(grey.empty() || grey.type() == CV_8UC1);
  resize(grey.cols, grey.rows);
  const std::size_t stride = static_cast<std::size_t>(width_) + 1;
  std::fill_n(sums_.data(), stride, 0u);
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

void IntegralImage::halve(const IntegralImage& finer) {
  resize(finer.width() / 2, finer.height() / 2);
  std::uint32_t* out = sums_.data();
  for (int y = 0; y <= height_; ++y) {
    const std::uint32_t* in = finer.row(2 * y);
    for (int x = 0; x <= width_; ++x) *out++ = in[2 * x];
  }
}

}  // namespace lcmslam
