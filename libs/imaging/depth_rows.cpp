#include <lcmslam/imaging/depth_rows.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

LCMSLAM_VECTORISED(measure_points,
                   (const std::uint16_t* depth, const float* ray, int columns, const DepthRowGeometry& g,
                    float* point, float* sigma),
                   (depth, ray, columns, g, point, sigma)) {
  for (int u = 0; u < columns; ++u) {
    const auto mm = static_cast<float>(depth[u]);
    const float z = mm >= g.nearest && mm <= g.farthest ? 0.001f * mm : nan_value;
    const float spread = z - g.offset;
    point[3 * u] = z * ray[2 * u];
    point[3 * u + 1] = z * ray[2 * u + 1];
    point[3 * u + 2] = z;
    sigma[u] = g.constant + g.quadratic * spread * spread;
  }
}

// `scale`: the noise of the least amplitude that is told, 1 of 255, a square metre.
LCMSLAM_VECTORISED(add_amplitude_noise,
                   (const std::uint8_t* amplitude, const std::uint16_t* depth, int columns, float scale,
                    float* sigma),
                   (amplitude, depth, columns, scale, sigma)) {
  for (int u = 0; u < columns; ++u) {
    const float z = 0.001f * static_cast<float>(depth[u]);
    sigma[u] += scale * z * z / std::sqrt(std::max(1.0f, static_cast<float>(amplitude[u])));
  }
}

LCMSLAM_VECTORISED(add_full_amplitude_noise,
                   (const std::uint16_t* depth, int columns, float scale, float* sigma),
                   (depth, columns, scale, sigma)) {
  for (int u = 0; u < columns; ++u) {
    const float z = 0.001f * static_cast<float>(depth[u]);
    sigma[u] += scale * z * z;
  }
}

LCMSLAM_VECTORISED(transform_points, (int columns, const DepthRowGeometry& g, float* point),
                   (columns, g, point)) {
  for (int u = 0; u < columns; ++u) {
    const float x = point[3 * u], y = point[3 * u + 1], z = point[3 * u + 2];
    for (int k = 0; k < 3; ++k)
      point[3 * u + k] = g.R[3 * k] * x + g.R[3 * k + 1] * y + g.R[3 * k + 2] * z + g.t[k];
  }
}

// As CameraModel's lens: Brown-Conrady with a rational radial part f = n / d of s = r^2, which has folded
// back where f + 2 s f' <= 0; beyond a pole of it (d <= 0) nothing is seen.
LCMSLAM_VECTORISED(project_points,
                   (const float* __restrict point, int columns, const LensRowGeometry& l, float* __restrict u,
                    float* __restrict v, float* __restrict z),
                   (point, columns, l, u, v, z)) {
  const LensRowGeometry lens = l;  // local: nothing that is written can change it
  for (int i = 0; i < columns; ++i) {
    const float depth = point[3 * i + 2];
    const float inverse = 1.0f / depth;
    const float x = point[3 * i] * inverse, y = point[3 * i + 1] * inverse;
    const float s = x * x + y * y;
    const float n = 1 + s * (lens.k1 + s * (lens.k2 + s * lens.k3));
    const float d = 1 + s * (lens.k4 + s * (lens.k5 + s * lens.k6));
    const float dn = lens.k1 + s * (2 * lens.k2 + s * 3 * lens.k3);
    const float dd = lens.k4 + s * (2 * lens.k5 + s * 3 * lens.k6);
    const float f = n / d;
    const float xd = x * f + 2 * lens.p1 * x * y + lens.p2 * (s + 2 * x * x);
    const float yd = y * f + lens.p1 * (s + 2 * y * y) + 2 * lens.p2 * x * y;
    const float column = lens.fx * xd + lens.cx, row = lens.fy * yd + lens.cy;
    const bool seen = (depth > 1e-9f) & (d > 0) & (n > 0) & (n + 2 * s * (dn - f * dd) > 0) &
                      (column >= -0.5f) & (row >= -0.5f) & (column < lens.right) & (row < lens.bottom);
    u[i] = seen ? column : nan_value;
    v[i] = seen ? row : nan_value;
    z[i] = depth;
  }
}

}  // namespace

DepthRowGeometry depth_row_geometry(const RgbdCalibration& calibration, const Eigen::Isometry3d& T) {
  const DepthNoise& noise = calibration.depth_noise;
  DepthRowGeometry g{};
  g.nearest = static_cast<float>(std::max(1.0, std::ceil(calibration.depth_min * 1000)));
  g.farthest = static_cast<float>(std::min(65534.0, std::floor(calibration.depth_max * 1000)));
  g.constant = static_cast<float>(noise.constant);
  g.quadratic = static_cast<float>(noise.quadratic);
  g.offset = static_cast<float>(noise.offset);
  g.amplitude = static_cast<float>(noise.amplitude);
  for (int i = 0; i < 9; ++i) g.R[i] = static_cast<float>(T.linear()(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) g.t[i] = static_cast<float>(T.translation()[i]);
  return g;
}

LensRowGeometry lens_row_geometry(const CameraModel& camera) {
  LensRowGeometry l{};
  l.fx = static_cast<float>(camera.fx), l.fy = static_cast<float>(camera.fy);
  l.cx = static_cast<float>(camera.cx), l.cy = static_cast<float>(camera.cy);
  l.right = static_cast<float>(camera.width) - 0.5f;
  l.bottom = static_cast<float>(camera.height) - 0.5f;
  float* const coefficients[] = {&l.k1, &l.k2, &l.p1, &l.p2, &l.k3, &l.k4, &l.k5, &l.k6};
  for (std::size_t i = 0; i < camera.distortion.size(); ++i)
    *coefficients[i] = static_cast<float>(camera.distortion[i]);
  return l;
}

void unproject_row(const std::uint16_t* depth, const std::uint8_t* amplitude, const float* ray, int columns,
                   const DepthRowGeometry& geometry, float* point, float* sigma) {
  measure_points(depth, ray, columns, geometry, point, sigma);
  if (!(geometry.amplitude > 0)) return;
  if (amplitude)
    add_amplitude_noise(amplitude, depth, columns, geometry.amplitude * std::sqrt(255.0f), sigma);
  else
    add_full_amplitude_noise(depth, columns, geometry.amplitude, sigma);
}

void move_row(int columns, const DepthRowGeometry& geometry, float* point) {
  transform_points(columns, geometry, point);
}

void project_row(const float* point, int columns, const LensRowGeometry& lens, float* u, float* v, float* z) {
  project_points(point, columns, lens, u, v, z);
}

}  // namespace lcmslam
