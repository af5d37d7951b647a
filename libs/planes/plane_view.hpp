#pragma once
// How a camera sees a plane: between the places of the plane's grid and the camera's rays.

#include <Eigen/Geometry>

#include <lcmslam/planes/plane_moments.hpp>

namespace lcmslam {

class PlaneView {
 public:
  /// The grid lies where the plane was when it began; its places are brought into the plane as it is known
  /// now. The camera's centre is not in the plane.
  PlaneView(const Eigen::Isometry3d& T_map_grid, const PlaneEquation& plane,
            const Eigen::Isometry3d& T_map_camera);

  /// In the camera's frame, m, of a place in the grid, m.
  Eigen::Vector3d point(const Eigen::Vector2d& place) const { return to_camera_ * place.homogeneous(); }

  /// The plane was seen along a ray of the camera, and perhaps up to `aside` (rad) beside it. Looks flatter
  /// than 80 degrees do not tell where a plane ends, and are left out.
  void reach_to(const Eigen::Vector3d& ray, double aside);

  /// The places that may have been seen, m; empty before there is one.
  const Eigen::AlignedBox2d& box() const { return box_; }

 private:
  double distance_;            // m, of the camera from the plane
  Eigen::Matrix3d to_camera_;  // of (x, y, 1)
  Eigen::Matrix3d to_grid_;    // its inverse
  Eigen::AlignedBox2d box_;
};

}  // namespace lcmslam
