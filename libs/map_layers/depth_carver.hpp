#pragma once
// Writes depth images into an occupancy grid. Cells in which depth was measured are hit. Blocks of cells in
// front of the camera are projected into the image: a cell whose middle half is seen through by every pixel
// is missed; a block that is seen through as a whole, or hidden, is not looked at cell by cell. No ray is
// walked, so the work grows with the space seen and not with the pixels.
//
// A pixel without depth tells nothing, and neither does a cell on which hardly any pixel has depth. A hit
// wins over a miss.

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/map_layers/carving_view.hpp>
#include <lcmslam/map_layers/hit_cells.hpp>

namespace lcmslam {

class DepthCarver {
 public:
  /// `depth` as CarvingView::set() takes it. T_map_camera must be finite (std::invalid_argument), its
  /// translation within 2^18 cells of the map's origin.
  void carve(const cv::Mat& depth, const CameraModel& camera, const Eigen::Isometry3d& T_map_camera,
             OccupancyGrid& grid);
  /// What the image hits in the grid's cells, for hits(); the grid stays as it is.
  void see(const cv::Mat& depth, const CameraModel& camera, const Eigen::Isometry3d& T_map_camera,
           const OccupancyGrid& grid);

  /// What the last image hit, in the order of its pixels.
  std::vector<OccupancyChange> hits() const { return hits_.bits(); }

 private:
  using Flags = HitCells::Flags;
  struct Seeing;  // one image's projection
  enum class Sight { hidden, mixed, through };

  Seeing hits_of(const cv::Mat& depth, const CameraModel& camera, const Eigen::Isometry3d& T_map_camera,
                 const OccupancyGrid& grid);
  void collect_hits(const Seeing& seeing);
  Sight look(const Seeing& seeing, const Eigen::Vector3i& block, Flags& through) const;
  void miss(const Seeing& seeing, OccupancyGrid& grid) const;

  CarvingView view_;
  HitCells hits_;
};

}  // namespace lcmslam
