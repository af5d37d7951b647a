#include <lcmslam/surface/colour_lookup.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr float hidden_behind = 1.04f;  // times the depth of what is in front

// NaN is seen by no pixel: comparisons with it are false.
LCMSLAM_VECTORISED(find_colour_pixels,
                   (const float* points, int columns, const Lens& lens, std::int32_t* pixels),
                   (points, columns, lens, pixels)) {
  for (int u = 0; u < columns; ++u)
    pixels[u] = lens.pixel(points[3 * u], points[3 * u + 1], points[3 * u + 2]);
}

}  // namespace

void look_up_colours(const cv::Mat& points, const cv::Mat& colour, const Lens& lens, float footprint,
                     cv::Mat& found, cv::Mat& seen) {
  cv::Mat_<std::int32_t> pixels(points.size());
  for (int v = 0; v < points.rows; ++v)
    find_colour_pixels(points.ptr<float>(v), points.cols, lens, pixels.ptr<std::int32_t>(v));

  // The nearest depth in cells of the colour image that no two neighbouring points can both leave out.
  const int cell = std::max(1, static_cast<int>(std::ceil(1.5f * footprint)));
  cv::Mat_<float> nearest(colour.rows / cell + 1, colour.cols / cell + 1, 1e9f);
  const auto cell_of = [&](int pixel) -> float& {
    return nearest(pixel / lens.columns / cell, pixel % lens.columns / cell);
  };
  for (int v = 0; v < points.rows; ++v)
    for (int u = 0; u < points.cols; ++u) {
      const int pixel = pixels(v, u);
      if (pixel == lens.nothing) continue;
      float& depth = cell_of(pixel);
      depth = std::min(depth, points.at<cv::Vec3f>(v, u)[2]);
    }
  for (int v = 0; v < points.rows; ++v)
    for (int u = 0; u < points.cols; ++u) {
      const int pixel = pixels(v, u);
      if (pixel == lens.nothing || points.at<cv::Vec3f>(v, u)[2] > hidden_behind * cell_of(pixel)) continue;
      found.at<cv::Vec3b>(v, u) = colour.at<cv::Vec3b>(pixel / lens.columns, pixel % lens.columns);
      seen.at<std::uint8_t>(v, u) = 255;
    }
}

}  // namespace lcmslam
