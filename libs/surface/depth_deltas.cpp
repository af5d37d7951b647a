#include <lcmslam/surface/depth_deltas.hpp>

namespace lcmslam {
namespace {

constexpr int no_change = 127;  // of a byte's differences, -127 to 127
constexpr int escaped = 255;    // a depth of two bytes follows, the low one first

}  // namespace

std::vector<std::uint8_t> pack_depth(const cv::Mat& depth) {
  std::vector<std::uint8_t> bytes(3 * depth.total());
  std::uint8_t* next = bytes.data();
  int last = 0;
  for (int v = 0; v < depth.rows; ++v) {
    const auto* row = depth.ptr<std::uint16_t>(v);
    for (int u = 0; u < depth.cols; ++u) {
      const int code = row[u] - last + no_change;
      last = row[u];
      if (code >= 0 && code < escaped) {
        *next++ = static_cast<std::uint8_t>(code);
        continue;
      }
      *next++ = escaped;
      *next++ = static_cast<std::uint8_t>(last & 255);
      *next++ = static_cast<std::uint8_t>(last >> 8);
    }
  }
  return {bytes.data(), next};
}

cv::Mat unpack_depth(const std::vector<std::uint8_t>& bytes, cv::Size size) {
  cv::Mat depth(size, CV_16UC1);
  const std::uint8_t* next = bytes.data();
  int last = 0;
  for (int v = 0; v < depth.rows; ++v) {
    auto* row = depth.ptr<std::uint16_t>(v);
    for (int u = 0; u < depth.cols; ++u) {
      const int code = *next++;
      last = code == escaped ? next[0] | next[1] << 8 : last + code - no_change;
      next += code == escaped ? 2 : 0;
      row[u] = static_cast<std::uint16_t>(last);
    }
  }
  return depth;
}

}  // namespace lcmslam
