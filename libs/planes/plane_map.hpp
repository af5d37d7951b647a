#pragma once
// The planes of a map: what frames show of them, put together.

#include <vector>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/planes/frame_planes.hpp>
#include <lcmslam/planes/plane_grid.hpp>

namespace lcmslam {

enum class PlaneLabel { other, floor, table_top, ceiling, wall };

/// A part of a plane that hangs together. Parts of one plane (two table tops of the same height) share its
/// normal, offset and covariance.
struct PlanePatch {
  PlaneLabel label = PlaneLabel::other;
  PlaneFit fit;  ///< map frame; its variance holds what all points err by alike
  std::vector<Eigen::Vector3d>
      outline;      ///< m, in the plane, counter-clockwise as seen from the normal's side
  double area = 0;  ///< m^2 of what was seen
  int looks = 0;    ///< frames that showed the plane
};

class PlaneMap {
 public:
  /// Throws std::invalid_argument for a setting that is wrong.
  explicit PlaneMap(const PlaneMapSettings& settings = {});

  /// The planes of a depth image taken at T_map_depth; `cells` those of the finder that found them. What was
  /// seen in min_looks images belongs to a plane's outline.
  void insert(const FramePlanes& found, const CellMoments& cells, const Eigen::Isometry3d& T_map_depth);

  /// All parts with a label's least area, in the order in which their planes were found. `up` is unit.
  std::vector<PlanePatch> patches(const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ()) const;

  std::size_t size() const { return planes_.size(); }
  std::size_t memory_bytes() const;

 private:
  struct Plane {
    PlaneMoments moments;
    PlaneFit fit;
    Eigen::Isometry3d T_map_plane;  ///< of the grid: as it was when it began
    Eigen::Vector3d seen_from;
    PlaneGrid grid;
    int looks = 0;
  };

  void look(const cv::Mat& labels, const std::vector<std::size_t>& plane_of, const CellMoments& cells,
            const Eigen::Isometry3d& T_map_depth);
  Plane* partner(const PlaneFit& fit);
  void make_room(const Eigen::Vector3d& place);

  PlaneMapSettings settings_;
  std::vector<Plane> planes_;
};

}  // namespace lcmslam
