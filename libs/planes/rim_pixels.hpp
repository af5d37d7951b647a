#pragma once
// Loops over all pixels of a cell at the rim of planes, compiled for the best instruction set.

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include <lcmslam/planes/cell_moments.hpp>

namespace lcmslam {

/// A plane that may have pixels in a cell.
struct NearPlane {
  float x, y, z, offset;  // of its equation
  std::uint8_t label;
};

class RimPixels {
 public:
  /// Pixels of a greater deviation than `max_sigma` (m) are nobody's.
  RimPixels(const CellMoments& cells, double max_sigma);

  /// Takes the pixels of a cell from a depth image.
  void load(const cv::Mat& depth, int column, int row);

  /// The pixels that lie within `gate` sigmas of the plane become its own, but for those that are another's
  /// and stay so: of two planes that bulge (a box's sides) a ray meets the farther one last and enters there,
  /// of two that form a corner the nearer one; what noise makes of the point does not count. Where two planes
  /// do neither, the nearer to the point has it. `bulge` tells it of this plane and each other label: 1 for
  /// bulging, -1 for a corner, 0 for neither.
  void offer(const NearPlane& plane, const std::int32_t* bulge, float gate);

  /// Whose they are: writes the labels of the cell that was loaded, 0 for nobody's.
  void write(cv::Mat& labels, int column, int row) const;

  /// Moments, of weight 1, of the cell's pixels with the plane's label that lie within `gate` sigmas of it.
  PlaneMoments moments_of(const NearPlane& plane, const cv::Mat& labels, int column, int row, float gate);

 private:
  const CellMoments& cells_;
  float max_sigma_;
  std::size_t count_;                       // pixels, with some more that fill the last lanes
  std::vector<float> x_, y_, z_;            // m
  std::vector<float> sigma_;                // m; negative for nobody's
  std::vector<float> along_;                // where its plane is met on the ray, as a share of the depth
  std::vector<std::int32_t> own_, labels_;  // label of its plane, 0: none
};

/// Labels without the pixels that a filter smoothed with their neighbour of another plane, which are within
/// `reach` pixels of it in their row or column.
cv::Mat without_smoothed(const cv::Mat& labels, int reach);

}  // namespace lcmslam
