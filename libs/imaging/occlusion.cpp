#include <lcmslam/imaging/occlusion.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lcmslam {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

// Nearest depth for each cell of the colour image; a cell is half a depth pixel wide.
class DepthBuffer {
 public:
  DepthBuffer(cv::Size colour_size, float footprint)
      : cell_(std::max(1.0f, 0.5f * footprint)),
        half_(0.6f * footprint),  // a little over one half: slanted surfaces spread
        nearest_(static_cast<int>(static_cast<float>(colour_size.height) / cell_) + 1,
                 static_cast<int>(static_cast<float>(colour_size.width) / cell_) + 1, infinity) {}

  void splat(const cv::Vec2f& pixel, float z) {
    const int left = std::max(0, cell(pixel[0] - half_));
    const int right = std::min(nearest_.cols - 1, cell(pixel[0] + half_));
    const int top = std::max(0, cell(pixel[1] - half_));
    const int bottom = std::min(nearest_.rows - 1, cell(pixel[1] + half_));
    for (int y = top; y <= bottom; ++y)
      for (int x = left; x <= right; ++x) nearest_(y, x) = std::min(nearest_(y, x), z);
  }

  float at(const cv::Vec2f& pixel) const { return nearest_(cell(pixel[1]), cell(pixel[0])); }

 private:
  int cell(float position) const { return static_cast<int>(std::floor((position + 0.5f) / cell_)); }

  float cell_;
  float half_;
  cv::Mat_<float> nearest_;
};

// Smaller of the depth steps to the two neighbours: the surface's slope, not the edge beside it.
float smaller_step(float before, float z, float after) {
  const float a = std::abs(z - before);
  const float b = std::abs(after - z);
  if (std::isnan(a)) return std::isnan(b) ? 0.0f : b;
  return std::isnan(b) ? a : std::min(a, b);
}

}  // namespace

void hide_occluded(RegisteredDepth& registered, cv::Size colour_size, int step) {
  const cv::Mat_<cv::Vec3f> points = registered.points;
  const cv::Mat_<float> sigma = registered.sigma;
  cv::Mat_<cv::Vec2f> pixels = registered.pixels;

  DepthBuffer buffer(colour_size, static_cast<float>(step) * registered.footprint);
  for (int v = 0; v < points.rows; v += step)
    for (int u = 0; u < points.cols; u += step)
      if (!std::isnan(pixels(v, u)[0])) buffer.splat(pixels(v, u), points(v, u)[2]);

  // Two (thinned) depth pixels of slope in each direction lie between a point and the farthest edge of a
  // splat that covers it; three standard deviations for each of the two points.
  constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
  const auto slopes = 2 * static_cast<float>(step);
  for (int v = 0; v < points.rows; v += step) {
    for (int u = 0; u < points.cols; u += step) {
      if (std::isnan(pixels(v, u)[0])) continue;
      const float z = points(v, u)[2];
      const float gap = z - buffer.at(pixels(v, u)) - 6 * sigma(v, u);
      if (!(gap > 0)) continue;
      const float horizontal = smaller_step(u > 0 ? points(v, u - 1)[2] : nothing, z,
                                            u + 1 < points.cols ? points(v, u + 1)[2] : nothing);
      const float vertical = smaller_step(v > 0 ? points(v - 1, u)[2] : nothing, z,
                                          v + 1 < points.rows ? points(v + 1, u)[2] : nothing);
      if (gap > slopes * (horizontal + vertical)) pixels(v, u) = {nothing, nothing};
    }
  }
}

}  // namespace lcmslam
