#pragma once
// What all ranges of a depth camera err by, over the range: a curve that nobody knows before, so that it may
// not bend the scene instead. A time-of-flight camera's wiggle is one (imaging/depth_error.hpp).
//
// A uniform cubic B-spline (de Boor 1978, "A practical guide to splines"): smooth, and four of its numbers
// count at a range.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace lcmslam {

class RangeCurve {
 public:
  /// The four numbers that count at a range, and by how much.
  struct Place {
    int first = 0;
    std::array<double, 4> weights{};
  };

  /// From 0 to `farthest`, m. A wiggle's period is a quarter of the unambiguous range: it gets four pieces.
  explicit RangeCurve(double farthest, int pieces = 16)
      : values(static_cast<std::size_t>(pieces + 3), 0.0), piece_(farthest / pieces) {}

  Place place(double range) const {
    const int last = static_cast<int>(values.size()) - 4;
    const double along = std::clamp(range / piece_, 0.0, last + 1.0);
    Place p;
    p.first = std::min(static_cast<int>(along), last);
    const double t = along - p.first, s = 1 - t;
    p.weights = {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6,
                 t * t * t / 6};
    return p;
  }

  /// m, as offset: the true range of a measured one is that much larger.
  double at(const Place& p) const {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += p.weights[i] * values[static_cast<std::size_t>(p.first) + i];
    return sum;
  }

  /// The range at which a number counts most, m.
  double range_of(int number) const { return (number - 1) * piece_; }

  std::vector<double> values;  ///< m

 private:
  double piece_;  // m
};

}  // namespace lcmslam
