#pragma once
// Where in a plane its points were seen: a grid that grows, and the outlines of what hangs together.

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace lcmslam {

class PlaneGrid {
 public:
  /// `cell` in m. A cell belongs to the plane once it was seen `looks` times.
  PlaneGrid(double cell, int looks) : cell_(cell), looks_(static_cast<std::uint8_t>(looks)) {}

  /// A look of one frame: `is_seen(place)` says of the middle of each cell of the box, in the plane's own
  /// coordinates (m), whether the frame showed the plane there. Cells that have their looks are not asked
  /// again. What lies beyond 1000 m is left out.
  template <typename IsSeen>
  void look(const Eigen::AlignedBox2d& box, IsSeen is_seen) {
    const cv::Rect area = reach(box);
    for (int y = area.y; y < area.y + area.height; ++y) {
      auto* looks = seen_[y - top_] - left_;
      for (int x = area.x; x < area.x + area.width; ++x)
        if (looks[x] < looks_ && is_seen(Eigen::Vector2d(cell_ * (x + 0.5), cell_ * (y + 0.5)))) ++looks[x];
    }
  }

  /// One outline for each part of connected cells that belong to the plane, its holes filled,
  /// counter-clockwise in plane coordinates, m; and the area of its cells, m^2. Gaps of one cell are closed.
  struct Part {
    std::vector<Eigen::Vector2d> outline;
    double area = 0;
  };
  std::vector<Part> parts() const;

  std::size_t memory_bytes() const { return seen_.total() * seen_.elemSize(); }

 private:
  cv::Rect reach(const Eigen::AlignedBox2d& box);

  double cell_;
  std::uint8_t looks_;
  int left_ = 0, top_ = 0;       // cell of seen_(0, 0)
  cv::Mat_<std::uint8_t> seen_;  // looks of each cell, up to looks_
};

}  // namespace lcmslam
