#pragma once
// The image in 16 x 12 cells: for spreading observations and new landmarks evenly, and for neighbours.

#include <algorithm>
#include <cstddef>

#include <lcmslam/features/feature.hpp>

namespace lcmslam {

class ImageGrid {
 public:
  static constexpr int column_count = 16, row_count = 12, cell_count = column_count * row_count;

  explicit ImageGrid(const FeatureFrame& frame)
      : cells_per_x_(column_count / std::max(1.0, static_cast<double>(frame.width))),
        cells_per_y_(row_count / std::max(1.0, static_cast<double>(frame.height))) {}

  int column(double x) const { return clamped(x * cells_per_x_, column_count); }
  int row(double y) const { return clamped(y * cells_per_y_, row_count); }
  /// Pixels outside belong to the nearest cell.
  std::size_t cell(double x, double y) const {
    return static_cast<std::size_t>(row(y) * column_count + column(x));
  }

 private:
  static int clamped(double value, int count) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(count - 1)));
  }
  double cells_per_x_, cells_per_y_;
};

}  // namespace lcmslam
