#pragma once
// Registered depth points around positions in the colour image, and the depth that they give there.

#include <vector>

#include <lcmslam/imaging/depth_registration.hpp>

namespace lcmslam {

/// One registered depth point near a query.
struct DepthNeighbour {
  float du, dv;  ///< colour pixels from the query, in units of the footprint
  float q;       ///< 1 / z
  float sigma;   ///< m
};

constexpr float neighbour_reach = 1.5f;  ///< depth pixels, from a query to its farthest neighbour

/// Adds a point at colour pixel (u, v) if it is near enough to the query.
inline void add_neighbour(const cv::Point2f& query, float footprint, float u, float v, float z, float sigma,
                          std::vector<DepthNeighbour>& neighbours) {
  const float du = (u - query.x) / footprint, dv = (v - query.y) / footprint;
  if (!(du * du + dv * dv <= neighbour_reach * neighbour_reach)) return;
  neighbours.push_back({du, dv, 1 / z, sigma});
}

/// Finds the points around queries. The colour image is divided into square cells, of which only those that
/// a query looks into keep points.
///
///   add() every point for which wants() is true, sort(), then find().
class NeighbourCells {
 public:
  /// `footprint`: colour pixels between neighbouring depth pixels.
  NeighbourCells(const std::vector<cv::Point2f>& queries, float footprint);

  /// `u`, `v` in the image, not NaN.
  bool wants(float u, float v) const {
    const int x = cell(u), y = cell(v);
    return x < columns_ && y < rows_ && wanted_[index(x, y)] != 0;
  }
  void add(float u, float v, float z, float sigma);
  void sort();
  /// In the order in which they were added, cell by cell.
  void find(const cv::Point2f& query, std::vector<DepthNeighbour>& neighbours) const;

 private:
  struct Point {
    float u, v, z, sigma;
  };
  int cell(float position) const { return static_cast<int>((position + 0.5f) / cell_); }
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y * columns_ + x); }

  float footprint_, cell_;
  int columns_ = 0, rows_ = 0;
  std::vector<char> wanted_;
  std::vector<int> cells_;  // of points_
  std::vector<Point> points_, sorted_;
  std::vector<int> first_;
};

/// Depth and standard deviation (m) at the query, from the plane through its neighbours; false where there is
/// no such plane. `pitch`: rad between depth pixels; `pixel_sigma`: of the query, in units of the footprint.
bool interpolate_depth(const std::vector<DepthNeighbour>& neighbours, float pitch, float pixel_sigma,
                       float& z, float& sigma);

}  // namespace lcmslam
