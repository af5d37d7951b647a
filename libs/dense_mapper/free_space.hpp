#pragma once
// Evidence by free space: what a depth image sees through is not there (any more). The image is kept as the
// nearest depth around each viewing direction, so that a point counts as seen through only where everything
// beside its ray is farther, too: edges, thin things and grazing surfaces stay.

#include <cstdint>
#include <vector>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct FreeSpaceSettings {
  bool enabled = true;
  double sigmas = 4;
  double tolerance = 0.05;
  double lateral = 0.03;
  int rotation = 7;

  void describe(SettingsVisitor& s) {
    s.flag("enabled", enabled, "what a depth image sees through leaves the map");
    s.number("sigmas", sigmas, "", {0, 1000},
             "of the depth noise that a point must lie before what is measured, besides tolerance");
    s.number("tolerance", tolerance, "m", {0, 1000},
             "across the surface that a point must lie before what is measured, besides sigmas");
    s.number("lateral", lateral, "m", {0, 1000},
             "around the point that must be free, too: from one cell to four");
    s.number("rotation", rotation, "", {1, 100},
             "each frame follows one of so many rays in each row and column");
  }
};

enum class Visibility { unknown, supported, seen_through, hidden };

class FreeSpaceView {
 public:
  /// `cloud` in the camera frame (x right, y down, z forward; m), its sigmas along the ray. Points at z < 0.1
  /// m, and beyond 84 degrees to a side, are left out.
  FreeSpaceView(const Cloud& cloud, const FreeSpaceSettings& settings);

  /// Of a point and its normal in the camera frame.
  Visibility judge(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  /// Through a cell's centre, z = 1.
  Eigen::Vector3f ray(int column, int row) const;
  /// Farthest z that was measured in a cell; 0 where nothing was.
  float reach(int column, int row) const { return far_[index(column, row)]; }

 private:
  static constexpr int levels = 3;  // neighbourhoods of radius 1, 2, 4 cells
  std::size_t index(int column, int row) const { return static_cast<std::size_t>(row * columns_ + column); }
  /// Before the cast to int: what is far out fits none.
  bool is_inside(float u, float v) const {
    return u >= 0 && v >= 0 && u < static_cast<float>(columns_) && v < static_cast<float>(rows_);
  }
  std::vector<float> nearest_around(const std::vector<float>& image, int radius) const;

  FreeSpaceSettings settings_;
  float pitch_ = 0, left_ = 0, top_ = 0;  // of the grid over x / z, y / z
  int columns_ = 0, rows_ = 0;
  std::vector<float> near_, far_;      // z less (more) some sigmas, 0 where nothing was measured
  std::vector<float> around_[levels];  // the least near_ of the neighbourhood, 0 where a cell is unknown
};

}  // namespace lcmslam
