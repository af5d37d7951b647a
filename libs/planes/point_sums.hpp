#pragma once
// Sums over points, some lanes at once, for loops that the compiler vectorises (LCMSLAM_VECTORISED).

#include <lcmslam/planes/plane_moments.hpp>

namespace lcmslam {

struct PointSums {
  static constexpr int lanes = 8;
  float n[lanes] = {}, x[lanes] = {}, y[lanes] = {}, z[lanes] = {}, xx[lanes] = {}, xy[lanes] = {},
        xz[lanes] = {}, yy[lanes] = {}, yz[lanes] = {}, zz[lanes] = {};

  /// A point, counted from a place near it: differences of squares of metres would drown what makes points
  /// plane. `one`: 1, or 0 with a point of zeros for what does not count.
  __attribute__((always_inline)) void add(int lane, float one, float dx, float dy, float dz) {
    n[lane] += one;
    x[lane] += dx;
    y[lane] += dy;
    z[lane] += dz;
    xx[lane] += dx * dx;
    xy[lane] += dx * dy;
    xz[lane] += dx * dz;
    yy[lane] += dy * dy;
    yz[lane] += dy * dz;
    zz[lane] += dz * dz;
  }
  /// In the order of sums_of_points.
  __attribute__((always_inline)) const float* of(int k) const {
    const float* const all[sums_of_points] = {n, x, y, z, xx, xy, xz, yy, yz, zz};
    return all[k];
  }
};

}  // namespace lcmslam
