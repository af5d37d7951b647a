#pragma once
// Which parts of a depth image the colour camera may see near some of its pixels, without registering all of
// it.

#include <vector>

#include <lcmslam/imaging/depth_rows.hpp>

namespace lcmslam {

/// A depth image in tiles. A tile's rays and its nearest and farthest depth bound where in the colour
/// camera's ideal (undistorted) image its points lie: those tiles are left out whose bounds reach no query.
class DepthTiles {
 public:
  DepthTiles() = default;
  /// `rays`: ray_table() of the depth camera.
  DepthTiles(const CameraModel& colour, const cv::Mat& rays);

  /// Calls work(row, first column, columns) for pieces of rows that together hold every depth pixel which may
  /// lie within `reach` colour pixels, along both sides, of one of `queries`; row by row, from left to right.
  template <class Work>
  void around(const cv::Mat& depth, const std::vector<cv::Point2f>& queries, float reach,
              const DepthRowGeometry& geometry, const Work& work) const {
    const std::vector<char> wanted = wanted_tiles(depth, queries, reach, geometry);
    for (int v = 0; v < depth.rows; ++v) {
      const char* row = wanted.data() + static_cast<std::ptrdiff_t>(v / tile_rows) * columns_;
      for (int x = 0; x < columns_;) {
        int end = x;
        while (end < columns_ && row[end] != 0) ++end;
        const int first = x * tile_columns;
        if (end > x) work(v, first, std::min(end * tile_columns, depth.cols) - first);
        x = end + 1;
      }
    }
  }

 private:
  // As small as the surroundings of a feature: larger ones bring what nobody asks for.
  static constexpr int tile_rows = 4, tile_columns = 8;
  std::vector<char> wanted_tiles(const cv::Mat& depth, const std::vector<cv::Point2f>& queries, float reach,
                                 const DepthRowGeometry& geometry) const;

  CameraModel colour_;
  float stretch_x_ = 0, stretch_y_ = 0;  // of the ideal image a colour pixel, at most
  int columns_ = 0, rows_ = 0;
  std::vector<float> left_, top_, right_, bottom_;  // of each tile's rays: x/z and y/z
};

}  // namespace lcmslam
