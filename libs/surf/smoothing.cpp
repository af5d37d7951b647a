#include <lcmslam/surf/smoothing.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <lcmslam/parallel/instruction_set.hpp>
#include <lcmslam/parallel/rows.hpp>

namespace lcmslam {
namespace {

constexpr int radius = 4;
constexpr float smoothing_size2 = 5.3f * 5.3f * 2.f;

struct NineRows {
  const std::uint8_t* row[2 * radius + 1];
};

LCMSLAM_VECTORISED(smooth_columns, (const NineRows& in, int n, std::uint16_t* __restrict out), (in, n, out)) {
  const NineRows rows = in;  // local: nothing that is written can change it
  for (int x = 0; x < n; ++x)
    out[x] =
        static_cast<std::uint16_t>(rows.row[0][x] + rows.row[8][x] + 8 * (rows.row[1][x] + rows.row[7][x]) +
                                   28 * (rows.row[2][x] + rows.row[6][x]) +
                                   56 * (rows.row[3][x] + rows.row[5][x]) + 70 * rows.row[4][x]);
}

// in[0] lies `radius` pixels left of out[0].
LCMSLAM_VECTORISED(smooth_row, (const std::uint16_t* in, int n, std::uint8_t* __restrict out), (in, n, out)) {
  for (int x = 0; x < n; ++x) {
    const int sum = in[x] + in[x + 8] + 8 * (in[x + 1] + in[x + 7]) + 28 * (in[x + 2] + in[x + 6]) +
                    56 * (in[x + 3] + in[x + 5]) + 70 * in[x + 4];
    out[x] = static_cast<std::uint8_t>((sum + 32768) >> 16);
  }
}

}  // namespace

float unsmoothed_size(float size) {
  return std::sqrt(std::max(1.f, size * size - smoothing_size2));
}

float smoothed_size(float size) {
  return std::sqrt(size * size + smoothing_size2);
}

const cv::Mat& BinomialSmoother::smooth(const cv::Mat& grey) {
  CV_Assert(grey.type() == CV_8UC1 && !grey.empty());
  smooth_.create(grey.size(), CV_8UC1);
  parallel_rows(0, grey.rows, [&](int begin, int end) {
    thread_local std::vector<std::uint16_t> sums;
    const auto width = static_cast<std::size_t>(grey.cols);
    if (sums.size() < width + 2 * radius) sums.resize(width + 2 * radius);
    for (int y = begin; y < end; ++y) {
      NineRows rows;
      for (int i = -radius; i <= radius; ++i)
        rows.row[i + radius] = grey.ptr<std::uint8_t>(std::clamp(y + i, 0, grey.rows - 1));
      smooth_columns(rows, grey.cols, sums.data() + radius);
      std::fill_n(sums.data(), radius, sums[radius]);
      std::fill_n(sums.data() + radius + width, radius, sums[radius + width - 1]);
      smooth_row(sums.data(), grey.cols, smooth_.ptr<std::uint8_t>(y));
    }
  });
  return smooth_;
}

}  // namespace lcmslam
