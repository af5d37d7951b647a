#include <lcmslam/imaging/depth_filter.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/imaging/depth_filter_parts.hpp>
#include <lcmslam/parallel/instruction_set.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

std::unique_ptr<DepthFilterPart> make_part(const std::string& name, const DepthFilterSettings& settings) {
  if (name == "amplitude") return make_amplitude_filter(settings.amplitude);
  if (name == "jump_edges") return make_jump_edge_filter(settings.jump_edges);
  if (name == "speckle") return make_speckle_filter(settings.speckle);
  return make_bilateral_filter(settings.bilateral);
}

// d(1/z) = dz / z^2.
LCMSLAM_VECTORISED(invert_row,
                   (const std::uint16_t* depth, int columns, const DepthNoise& noise, float* inverse,
                    float* sigma),
                   (depth, columns, noise, inverse, sigma)) {
  const auto constant = static_cast<float>(noise.constant);
  const auto quadratic = static_cast<float>(noise.quadratic);
  const auto offset = static_cast<float>(noise.offset);
  for (int u = 0; u < columns; ++u) {
    const float z = 0.001f * static_cast<float>(depth[u]);
    const float q = 1.0f / std::max(z, 0.001f);
    const float spread = z - offset;
    inverse[u] = z > 0 ? q : 0.0f;
    sigma[u] = q * q * (constant + quadratic * spread * spread);
  }
}

LCMSLAM_VECTORISED(add_amplitude_noise,
                   (const std::uint8_t* amplitude, int columns, const DepthNoise& noise, float* sigma),
                   (amplitude, columns, noise, sigma)) {
  const auto scale = static_cast<float>(noise.amplitude * std::sqrt(255.0));
  for (int u = 0; u < columns; ++u)
    sigma[u] += scale / std::sqrt(std::max(1.0f, static_cast<float>(amplitude[u])));
}

}  // namespace

DepthFilter::DepthFilter(const RgbdCalibration& calibration, const DepthFilterSettings& settings)
    : noise_(calibration.depth_noise) {
  check(settings, "depth filter");
  const CameraModel& camera = calibration.depth_registered ? calibration.colour : calibration.depth;
  image_.independent = noise_.amplitude > 0;
  image_.pitch_x = static_cast<float>(1 / camera.fx);
  image_.pitch_y = static_cast<float>(1 / camera.fy);
  for (const std::string& name : settings.parts) parts_.push_back(make_part(name, settings));
}

void DepthFilter::operator()(cv::Mat& depth, const cv::Mat& amplitude) {
  if (depth.type() != CV_16UC1 ||
      (!amplitude.empty() && (amplitude.type() != CV_8UC1 || amplitude.size() != depth.size())))
    throw std::invalid_argument("depth filter: depth must have 16 bits, amplitude 8 and the same size");
  if (parts_.empty()) return;
  image_.depth = depth;
  image_.amplitude = amplitude;
  prepare();
  for (const auto& part : parts_) part->apply(image_);
  image_.depth.release();
  image_.amplitude.release();
}

double DepthFilter::noise_left() const {
  if (!image_.independent) return 1;
  double left = 1;
  for (const auto& part : parts_) left *= part->noise_left();
  return left;
}

void DepthFilter::prepare() {
  const cv::Size size = image_.depth.size();
  if (image_.sigma.size() != size) {
    image_.sigma.create(size);
    image_.inverse.create(size + cv::Size(2 * DepthImage::border, 2 * DepthImage::border));
    image_.inverse.setTo(0);
  }
  const bool has_amplitude = noise_.amplitude > 0;
  for (int v = 0; v < size.height; ++v) {
    auto* sigma = image_.sigma.ptr<float>(v);
    invert_row(image_.depth.ptr<std::uint16_t>(v), size.width, noise_, image_.inverse_row(v), sigma);
    if (!has_amplitude) continue;
    if (image_.amplitude.empty())
      for (int u = 0; u < size.width; ++u) sigma[u] += static_cast<float>(noise_.amplitude);
    else
      add_amplitude_noise(image_.amplitude.ptr<std::uint8_t>(v), size.width, noise_, sigma);
  }
}

}  // namespace lcmslam
