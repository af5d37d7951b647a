#pragma once
// Where in a plane its points were seen: a grid that grows, and the outlines of what hangs together.

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace lcmslam {

class PlaneGrid {
 public:
  /// `cell` in m.
  explicit PlaneGrid(double cell) : cell_(cell) {}

  /// Places in the plane's own coordinates, m. Those beyond 1000 m are left out.
  void add(const std::vector<Eigen::Vector2d>& places);

  /// One outline for each part of connected cells that were hit at least `hits` times, its holes filled,
  /// counter-clockwise in plane coordinates, m; and the area of its cells, m^2. Gaps of one cell are closed.
  struct Part {
    std::vector<Eigen::Vector2d> outline;
    double area = 0;
  };
  std::vector<Part> parts(int hits) const;

  std::size_t memory_bytes() const { return hits_.total() * hits_.elemSize(); }

 private:
  void reach(int left, int top, int right, int bottom);

  double cell_;
  int left_ = 0, top_ = 0;       // cell of hits_(0, 0)
  cv::Mat_<std::uint8_t> hits_;  // saturated
};

}  // namespace lcmslam
