#include <lcmslam/features/feature.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lcmslam {

Descriptor to_bytes(const float* descriptor64) {
  Descriptor bytes;
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    const float value = std::floor(128.f + 127.f * descriptor64[k] + 0.5f);
    // std::max(0, NaN) is 0: what is not a number becomes 0 instead of undefined behaviour.
    bytes[k] = static_cast<std::uint8_t>(std::min(255.f, std::max(0.f, value)));
  }
  return bytes;
}

double pixel_sigma(const Feature& feature, const FeatureFrame& frame) {
  constexpr double size_of_sigma = 25, least = 0.7;  // pixels; of the frame's sigma
  return frame.pixel_sigma * (feature.size > 0 ? std::max(least, feature.size / size_of_sigma) : 1);
}

Eigen::Matrix3d point_covariance(const Feature& feature, const FeatureFrame& frame) {
  if (feature.kind != MeasurementKind::point || !feature.point.allFinite() || !(feature.point.z() > 0))
    throw std::invalid_argument("point_covariance: the feature has no 3-D point in front of the camera");
  if (!(feature.depth_sigma > 0) || !(frame.pixel_sigma > 0) || !(frame.fx > 0) || !(frame.fy > 0))
    throw std::invalid_argument("point_covariance: depth_sigma, pixel_sigma, fx and fy must be positive");
  const Eigen::Vector3d point = feature.point.cast<double>();
  const Eigen::Vector3d ray = point.normalized();
  const double along = feature.depth_sigma;
  const double across = pixel_sigma(feature, frame) * point.z() / (0.5 * (frame.fx + frame.fy));
  // Isotropic across the ray: the same for every rotation that turns z into the ray.
  const Eigen::Matrix3d projector = ray * ray.transpose();
  return along * along * projector + across * across * (Eigen::Matrix3d::Identity() - projector);
}

}  // namespace lcmslam
