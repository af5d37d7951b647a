#include <lcmslam/surface/lens.hpp>

#include <algorithm>

namespace lcmslam {
namespace {

float widest_ray(const CameraModel& camera) {
  double widest = 0;
  const auto look = [&](double u, double v) {
    widest = std::max(widest, camera.ray({u, v}).head<2>().squaredNorm());
  };
  for (int i = 0; i <= 64; ++i) {  // along the border
    const double u = i / 64.0 * camera.width - 0.5, v = i / 64.0 * camera.height - 0.5;
    for (const double end : {-0.5, camera.height - 0.5}) look(u, end);
    for (const double end : {-0.5, camera.width - 0.5}) look(end, v);
  }
  return static_cast<float>(1.001 * widest);
}

/// Looked for in a grid over the image.
float greatest_bend(const CameraModel& camera) {
  constexpr int steps = 24;
  double greatest = 0;
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; j <= steps; ++j) {
      const Eigen::Vector2d pixel(i * camera.width / double{steps} - 0.5,
                                  j * camera.height / double{steps} - 0.5);
      const Eigen::Vector2d ideal = camera.undistort(pixel);
      const double distance = (ideal - Eigen::Vector2d(camera.cx, camera.cy)).norm();
      if (distance > 1) greatest = std::max(greatest, (pixel - ideal).norm() / distance);
    }
  return static_cast<float>(1.1 * greatest);
}

}  // namespace

Lens::Lens(const CameraModel& camera)
    : fx(static_cast<float>(camera.fx)),
      fy(static_cast<float>(camera.fy)),
      cx(static_cast<float>(camera.cx + 0.5)),
      cy(static_cast<float>(camera.cy + 0.5)),
      width(static_cast<float>(camera.width)),
      height(static_cast<float>(camera.height)),
      widest(widest_ray(camera)),
      bend(camera.distortion.empty() ? 0.0f : greatest_bend(camera)),
      columns(camera.width),
      nothing(camera.width * camera.height) {
  float* const coefficients[] = {&k1, &k2, &p1, &p2, &k3, &k4, &k5, &k6};
  for (std::size_t i = 0; i < 8; ++i)
    *coefficients[i] = i < camera.distortion.size() ? static_cast<float>(camera.distortion[i]) : 0.0f;
  const auto all_zero = [&](std::size_t first, std::size_t last) {
    return std::all_of(coefficients + first, coefficients + last, [](const float* k) { return *k == 0; });
  };
  kind = !all_zero(5, 8) ? LensKind::rational : all_zero(0, 5) ? LensKind::pinhole : LensKind::polynomial;
}

}  // namespace lcmslam
