#pragma once
// Normals of a point image, as they are fitted: the inverse depth of a plane n . p = 1 is linear in the ray,
// 1/z = n . (x, y, 1), so that measured inverse depths around a pixel give n by linear least squares.

#include <cstddef>
#include <opencv2/core.hpp>

namespace lcmslam {

/// Rays and inverse depths of a point image, a plane each, with a border of nothing around.
struct InverseDepths {
  cv::Mat_<float> x, y, q;
  std::ptrdiff_t pitch = 0;  ///< floats from row to row

  explicit InverseDepths(const cv::Size& size);
  /// `point`: x, y, z of each column, m, NaN where there is none.
  void set_row(int v, const float* point, int columns);
  std::ptrdiff_t at(int v, int u) const;
};

/// At every `step`-th row and column, CV_32FC3, NaN where unknown. `sigma`: CV_32FC1, m, of these;
/// `pixel_pitch`: of the whole image's pixels, rad.
cv::Mat fit_normals(const InverseDepths& image, const cv::Mat& sigma, int step, float pixel_pitch);

}  // namespace lcmslam
