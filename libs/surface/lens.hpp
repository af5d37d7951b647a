#pragma once
// A camera model as vectorised loops need it.

#include <lcmslam/imaging/camera_model.hpp>

namespace lcmslam {

enum class LensKind { pinhole, polynomial, rational };  // k4 to k6 are 0 but in the last

struct Lens {
  float fx, fy, cx, cy;  ///< pixels; the upper left corner of the image is (0, 0), unlike CameraModel's
  float width, height;
  float k1, k2, p1, p2, k3, k4, k5, k6;
  float widest;  ///< greatest (x/z)^2 + (y/z)^2 in the image; beyond, the lens polynomial may fold back
  float bend;    ///< greatest share of its distance from the middle by which distortion moves a pixel
  int columns;
  int nothing;  ///< number of a pixel after the last
  LensKind kind;

  explicit Lens(const CameraModel& camera);

  /// Where a point (m) is seen, pixels; -1, -1 outside the image.
  struct Place {
    float u, v;
  };

  /// For a lens of the kind `of`, or a simpler one: the same numbers with less to compute.
  template <LensKind of = LensKind::rational>
  __attribute__((always_inline)) Place place(float x, float y, float z) const {
    const float inverse = 1 / (z > 0.01f ? z : 0.01f);
    const float a = x * inverse, b = y * inverse, r = a * a + b * b;
    float u = a, v = b;
    if constexpr (of != LensKind::pinhole) {
      float stretch = 1 + r * (k1 + r * (k2 + r * k3));
      if constexpr (of == LensKind::rational) stretch = stretch / (1 + r * (k4 + r * (k5 + r * k6)));
      u = a * stretch + 2 * p1 * a * b + p2 * (r + 2 * a * a);
      v = b * stretch + 2 * p2 * a * b + p1 * (r + 2 * b * b);
    }
    u = fx * u + cx;
    v = fy * v + cy;
    const bool unfolded = of == LensKind::pinhole || r <= widest;
    const bool inside = (z > 0.01f) & unfolded & (u >= 0) & (v >= 0) & (u < width) & (v < height);
    return {inside ? u : -1.0f, inside ? v : -1.0f};
  }

  /// Number of the pixel that sees a point (m), or `nothing`.
  template <LensKind of = LensKind::rational>
  __attribute__((always_inline)) int pixel(float x, float y, float z) const {
    const Place p = place<of>(x, y, z);
    const int column = static_cast<int>(p.u), row = static_cast<int>(p.v);
    return p.u >= 0 ? row * columns + column : nothing;
  }
};

}  // namespace lcmslam
