#pragma once
// A camera model as vectorised loops need it.

#include <lcmslam/imaging/camera_model.hpp>

namespace lcmslam {

struct Lens {
  float fx, fy, cx, cy;  ///< pixels; the upper left corner of the image is (0, 0), unlike CameraModel's
  float width, height;
  float k1, k2, p1, p2, k3, k4, k5, k6;
  float widest;  ///< greatest (x/z)^2 + (y/z)^2 in the image; beyond, the lens polynomial may fold back
  int columns;
  int nothing;  ///< number of a pixel after the last

  explicit Lens(const CameraModel& camera);

  /// Number of the pixel that sees a point (m), or `nothing`.
  __attribute__((always_inline)) int pixel(float x, float y, float z) const {
    const float inverse = 1 / (z > 0.01f ? z : 0.01f);
    const float a = x * inverse, b = y * inverse, r = a * a + b * b;
    const float bend = (1 + r * (k1 + r * (k2 + r * k3))) / (1 + r * (k4 + r * (k5 + r * k6)));
    const float u = fx * (a * bend + 2 * p1 * a * b + p2 * (r + 2 * a * a)) + cx;
    const float v = fy * (b * bend + 2 * p2 * a * b + p1 * (r + 2 * b * b)) + cy;
    const bool inside = (z > 0.01f) & (r <= widest) & (u >= 0) & (v >= 0) & (u < width) & (v < height);
    const int column = static_cast<int>(inside ? u : 0.0f), row = static_cast<int>(inside ? v : 0.0f);
    return inside ? row * columns + column : nothing;
  }
};

}  // namespace lcmslam
