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

}  // namespace

Lens::Lens(const CameraModel& camera)
    : fx(static_cast<float>(camera.fx)),
      fy(static_cast<float>(camera.fy)),
      cx(static_cast<float>(camera.cx + 0.5)),
      cy(static_cast<float>(camera.cy + 0.5)),
      width(static_cast<float>(camera.width)),
      height(static_cast<float>(camera.height)),
      widest(widest_ray(camera)),
      columns(camera.width),
      nothing(camera.width * camera.height) {
  float* const coefficients[] = {&k1, &k2, &p1, &p2, &k3, &k4, &k5, &k6};
  for (std::size_t i = 0; i < 8; ++i)
    *coefficients[i] = i < camera.distortion.size() ? static_cast<float>(camera.distortion[i]) : 0.0f;
}

}  // namespace lcmslam
