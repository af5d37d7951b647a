#include <lcmslam/imaging/constant_depth.hpp>

namespace lcmslam {

bool is_constant_depth(const cv::Mat& depth) {
  std::uint16_t value = 0;
  std::size_t valid = 0;
  for (int y = 0; y < depth.rows; ++y) {
    const auto* row = depth.ptr<std::uint16_t>(y);
    for (int x = 0; x < depth.cols; ++x) {
      if (row[x] == 0) continue;
      if (value != 0 && row[x] != value) return false;
      value = row[x];
      ++valid;
    }
  }
  return 2 * valid > depth.total();
}

}  // namespace lcmslam
