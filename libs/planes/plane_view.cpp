#include <lcmslam/planes/plane_view.hpp>

namespace lcmslam {

PlaneView::PlaneView(const Eigen::Isometry3d& T_map_grid, const PlaneEquation& plane,
                     const Eigen::Isometry3d& T_map_camera)
    : distance_(plane.distance(T_map_camera.translation())) {
  const Eigen::Matrix3d into_plane = Eigen::Matrix3d::Identity() - plane.normal * plane.normal.transpose();
  const Eigen::Vector3d origin =
      T_map_grid.translation() - plane.distance(T_map_grid.translation()) * plane.normal;
  Eigen::Matrix3d in_map;  // from the camera's centre
  in_map << into_plane * T_map_grid.linear().leftCols<2>(), origin - T_map_camera.translation();
  to_camera_ = T_map_camera.linear().transpose() * in_map;
  to_grid_ = to_camera_.inverse();
}

void PlaneView::reach_to(const Eigen::Vector3d& ray, double aside) {
  constexpr double least_cosine = 0.17;
  const Eigen::Vector3d place = to_grid_ * ray;  // times the ray's part that reaches the plane
  const double range = ray.norm() / place.z();
  if (!(place.z() > 0) || distance_ < least_cosine * range) return;
  const double around = aside * range * range / distance_;  // m in the plane
  box_.extend(place.hnormalized() - Eigen::Vector2d::Constant(around));
  box_.extend(place.hnormalized() + Eigen::Vector2d::Constant(around));
}

}  // namespace lcmslam
