#include <algorithm>
#include <array>
#include <cmath>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/imaging/depth_filter_parts.hpp>
#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr int reach = 2;
constexpr float spatial[reach + 1] = {1.0f, 0.8f, 0.4f};  // Gaussian of 1.5 pixels
static_assert(reach <= DepthImage::border);

/// Tukey's biweight of the difference; 0 for an invalid neighbour.
inline float weight(float difference, float inverse_width, float neighbour) {
  const float x = difference * inverse_width;
  const float w = std::max(0.0f, 1.0f - x * x);
  return neighbour > 0 ? w * w : 0.0f;
}

/// Means of pixels and their neighbours `stride` floats apart on both sides.
LCMSLAM_VECTORISED(smooth_row,
                   (const float* row, std::ptrdiff_t stride, const float* sigma, int columns, float width,
                    float* result),
                   (row, stride, sigma, columns, width, result)) {
  for (int u = 0; u < columns; ++u) {
    const float q = row[u];
    const float inverse_width = 1.0f / (width * sigma[u]);
    float sum = 0, weights = 1;
    for (int k = 1; k <= reach; ++k) {
      const float before = row[u - k * stride] - q, after = row[u + k * stride] - q;
      // In pairs: where only one side is there, a slope would pull the mean to it.
      const float w = spatial[k] * std::min(weight(before, inverse_width, row[u - k * stride]),
                                            weight(after, inverse_width, row[u + k * stride]));
      sum += w * (before + after);
      weights += 2 * w;
    }
    result[u] = q > 0 ? q + sum / weights : 0.0f;
  }
}

LCMSLAM_VECTORISED(write_row, (const float* inverse, int columns, std::uint16_t* depth),
                   (inverse, columns, depth)) {
  for (int u = 0; u < columns; ++u) {
    const float millimetres = std::min(65535.0f, 1000.0f / std::max(inverse[u], 0.01f) + 0.5f);
    depth[u] = depth[u] != 0 ? static_cast<std::uint16_t>(static_cast<int>(millimetres)) : std::uint16_t{0};
  }
}

class BilateralFilter : public DepthFilterPart {
 public:
  explicit BilateralFilter(const BilateralFilterSettings& settings)
      : width_(static_cast<float>(settings.range_sigmas * std::sqrt(2.0))),
        noise_left_(measure_noise_left()) {}

  double noise_left() const override { return noise_left_; }

  void apply(DepthImage& image) override {
    if (!image.independent) return;
    const cv::Size size = image.depth.size();
    if (smoothed_.size() != image.inverse.size()) {
      smoothed_.create(image.inverse.size());
      smoothed_.setTo(0);
    }
    // Along rows, then along columns as soon as the rows below are there.
    const auto stride = static_cast<std::ptrdiff_t>(smoothed_.step1());
    for (int v = 0; v < size.height + reach; ++v) {
      if (v < size.height)
        smooth_row(image.inverse_row(v), 1, image.sigma_row(v), size.width, width_, smoothed_row(v));
      if (v < reach) continue;
      const int done = v - reach;
      smooth_row(smoothed_row(done), stride, image.sigma_row(done), size.width, width_,
                 image.inverse_row(done));
      write_row(image.inverse_row(done), size.width, image.depth.ptr<std::uint16_t>(done));
    }
  }

 private:
  // Weights depend on the noise that they weigh, so what is left has no simple formula: seen on an image of
  // noise alone.
  double measure_noise_left() {
    constexpr int side = 128, rim = 2 * reach;
    constexpr float mean = 1, sigma = 1e-3f;  // 1/m
    DepthImage image;
    image.independent = true;
    image.depth = cv::Mat(side, side, CV_16UC1, cv::Scalar(1));
    image.sigma = cv::Mat_<float>(side, side, sigma);
    image.inverse = cv::Mat_<float>(side + 2 * DepthImage::border, side + 2 * DepthImage::border, 0.0f);
    Random random(1);
    for (int v = 0; v < side; ++v)
      for (int u = 0; u < side; ++u)
        image.inverse_row(v)[u] = mean + static_cast<float>(random.normal(0, static_cast<double>(sigma)));
    apply(image);
    double squares = 0;
    for (int v = rim; v < side - rim; ++v)
      for (int u = rim; u < side - rim; ++u) {
        const float off = (image.inverse_row(v)[u] - mean) / sigma;
        squares += static_cast<double>(off * off);
      }
    return std::sqrt(squares) / (side - 2 * rim);
  }

  float* smoothed_row(int v) { return smoothed_.ptr<float>(v + DepthImage::border) + DepthImage::border; }

  float width_;
  cv::Mat_<float> smoothed_;  // along rows, with the border of `inverse`
  double noise_left_;
};

}  // namespace

std::unique_ptr<DepthFilterPart> make_bilateral_filter(const BilateralFilterSettings& settings) {
  return std::make_unique<BilateralFilter>(settings);
}

}  // namespace lcmslam
