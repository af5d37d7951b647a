#pragma once
// Projective correspondences (Blais and Levine 1995): the partner of a point is what the target's
// camera saw in its direction. Constant cost for each point and a wide basin, at the price of wrong
// partners across depth edges, which rejection must remove.

#include <vector>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/registration/target.hpp>

namespace lcmslam {

/// An ideal pinhole for projecting, no distortion; pixels.
struct ProjectionGrid {
  int width = 160;
  int height = 120;
  double fx = 130, fy = 130, cx = 79.5, cy = 59.5;
};

class ProjectiveTarget : public Target {
 public:
  /// The cloud, in the target frame, is rendered into the grid of a camera at T_target_camera; the
  /// nearest point wins a cell. A window of (2 window + 1)^2 cells is searched for the closest.
  ProjectiveTarget(const Cloud& cloud, const Eigen::Isometry3d& T_target_camera,
                   const ProjectionGrid& grid = {}, int window = 2);

  bool find(const Eigen::Vector3f& point, float max_distance, TargetPoint& found) const override;
  std::size_t size() const override { return filled_; }

 private:
  bool cell_of(const Eigen::Vector3f& point, int& column, int& row, float& depth) const;

  Cloud cloud_;
  Eigen::Isometry3f T_camera_target_;
  ProjectionGrid grid_;
  int window_;
  std::vector<std::int32_t> cells_;  // index into the cloud, -1 when empty
  std::size_t filled_ = 0;
};

}  // namespace lcmslam
