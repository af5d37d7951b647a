#include <lcmslam/surface/halved_image.hpp>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr int edge_share = 32;  // what is farther than the nearest by this part of it lies beyond an edge

LCMSLAM_VECTORISED(halve_row,
                   (const std::uint16_t* upper, const std::uint16_t* lower, int columns, std::uint16_t* half),
                   (upper, lower, columns, half)) {
  for (int u = 0; u < columns; ++u) {
    const int a = upper[2 * u], b = upper[2 * u + 1], c = lower[2 * u], d = lower[2 * u + 1];
    constexpr int none = 1 << 17;  // beyond the farthest that can belong to a depth
    const int near_a = a > 0 ? a : none, near_b = b > 0 ? b : none, near_c = c > 0 ? c : none,
              near_d = d > 0 ? d : none;
    const int near_ab = near_a < near_b ? near_a : near_b, near_cd = near_c < near_d ? near_c : near_d;
    const int nearest = near_ab < near_cd ? near_ab : near_cd;
    const int farthest = nearest < none ? nearest + nearest / edge_share : 0;
    const int sum = (near_a <= farthest ? a : 0) + (near_b <= farthest ? b : 0) +
                    (near_c <= farthest ? c : 0) + (near_d <= farthest ? d : 0);
    const int count = (near_a <= farthest ? 1 : 0) + (near_b <= farthest ? 1 : 0) +
                      (near_c <= farthest ? 1 : 0) + (near_d <= farthest ? 1 : 0);
    // Rounded; such quotients are far enough from whole numbers that float truncates them as integers do.
    const float mean = static_cast<float>(2 * sum + count) / static_cast<float>(count > 0 ? 2 * count : 1);
    half[u] = static_cast<std::uint16_t>(static_cast<int>(mean));
  }
}

}  // namespace

cv::Mat halved_depth(const cv::Mat& depth) {
  cv::Mat half(depth.rows / 2, depth.cols / 2, CV_16UC1);
  for (int v = 0; v < half.rows; ++v)
    halve_row(depth.ptr<std::uint16_t>(2 * v), depth.ptr<std::uint16_t>(2 * v + 1), half.cols,
              half.ptr<std::uint16_t>(v));
  return half;
}

}  // namespace lcmslam
