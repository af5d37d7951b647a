#include <cmath>

#include <lcmslam/imaging/depth_filter_parts.hpp>

namespace lcmslam {
namespace {

class AmplitudeFilter : public DepthFilterPart {
 public:
  explicit AmplitudeFilter(const AmplitudeFilterSettings& settings)
      : least_(static_cast<int>(std::ceil(255 * settings.min_amplitude))) {}

  void apply(DepthImage& image) override {
    if (image.amplitude.empty() || least_ <= 0) return;
    for (int v = 0; v < image.depth.rows; ++v) {
      const auto* amplitude = image.amplitude.ptr<std::uint8_t>(v);
      auto* depth = image.depth.ptr<std::uint16_t>(v);
      float* inverse = image.inverse_row(v);
      for (int u = 0; u < image.depth.cols; ++u) {
        depth[u] = amplitude[u] < least_ ? std::uint16_t{0} : depth[u];
        inverse[u] = amplitude[u] < least_ ? 0.0f : inverse[u];
      }
    }
  }

 private:
  int least_;  // of 255
};

}  // namespace

std::unique_ptr<DepthFilterPart> make_amplitude_filter(const AmplitudeFilterSettings& settings) {
  return std::make_unique<AmplitudeFilter>(settings);
}

}  // namespace lcmslam
