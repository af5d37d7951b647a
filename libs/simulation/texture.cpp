#include <lcmslam/simulation/texture.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/imgproc.hpp>

namespace lcmslam {
namespace {

/// Each of four bytes in 16 bits of its own (little-endian).
std::uint64_t spread(const cv::Vec4b& bytes) {
  std::uint32_t packed = 0;
  std::memcpy(&packed, bytes.val, 4);
  std::uint64_t wide = packed;
  wide = (wide | wide << 16) & 0x0000ffff0000ffffull;
  return (wide | wide << 8) & 0x00ff00ff00ff00ffull;
}

}  // namespace

Texture::Texture(const cv::Mat& bgri, const Eigen::Vector2f& size)
    : size_(size), texel_(size.x() / static_cast<float>(bgri.cols)), levels_{bgri} {
  CV_Assert(bgri.type() == CV_8UC4 && size.minCoeff() > 0);
  while (levels_.back().cols > 1 || levels_.back().rows > 1) {
    const cv::Mat& fine = levels_.back();
    cv::Mat coarse;
    cv::resize(fine, coarse, {std::max(1, fine.cols / 2), std::max(1, fine.rows / 2)}, 0, 0, cv::INTER_AREA);
    levels_.push_back(coarse);
  }
}

// Four channels at once: each byte in 16 bits of a word, weights in 1/256.
cv::Vec4f Texture::bilinear(std::size_t level, const Eigen::Vector2f& position) const {
  const cv::Mat& image = levels_[level];
  float x = position.x() / size_.x(), y = position.y() / size_.y();
  x = (x - std::floor(x)) * static_cast<float>(image.cols) - 0.5f;
  y = (y - std::floor(y)) * static_cast<float>(image.rows) - 0.5f;
  const int left = static_cast<int>(x + 1) - 1, top = static_cast<int>(y + 1) - 1;
  const auto right_weight = static_cast<std::uint64_t>(16 * (x - static_cast<float>(left)) + 0.5f);
  const auto lower_weight = static_cast<std::uint64_t>(16 * (y - static_cast<float>(top)) + 0.5f);
  const auto wrap = [](int i, int n) { return i < 0 ? i + n : i >= n ? i - n : i; };
  const int x0 = wrap(left, image.cols), x1 = wrap(left + 1, image.cols);
  const auto* upper = image.ptr<cv::Vec4b>(wrap(top, image.rows));
  const auto* lower = image.ptr<cv::Vec4b>(wrap(top + 1, image.rows));
  const std::uint64_t sum =
      (16 - lower_weight) * ((16 - right_weight) * spread(upper[x0]) + right_weight * spread(upper[x1])) +
      lower_weight * ((16 - right_weight) * spread(lower[x0]) + right_weight * spread(lower[x1]));
  cv::Vec4f result;
  for (int c = 0; c < 4; ++c) result[c] = static_cast<float>(sum >> (16 * c) & 0xffff) * (1 / 256.0f);
  return result;
}

cv::Vec4f Texture::sample(const Eigen::Vector2f& position, float footprint) const {
  if (levels_.size() == 1) return cv::Vec4f(levels_[0].at<cv::Vec4b>(0, 0));  // plain
  const float scale = footprint / texel_;
  if (!(scale > 1)) return bilinear(0, position);
  int exponent = 0;  // scale = 2^(exponent - 1) * (1..2)
  const float mantissa = 2 * std::frexp(scale, &exponent);
  const std::size_t last = levels_.size() - 1;
  const std::size_t level = std::min(static_cast<std::size_t>(exponent - 1), last);
  const cv::Vec4f fine = bilinear(level, position);
  if (level == last) return fine;
  return fine + (mantissa - 1) * (bilinear(level + 1, position) - fine);
}

}  // namespace lcmslam
