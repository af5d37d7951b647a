#pragma once
// Frustum ICP (thesis section 3.5; Luck et al. 2000): only source points that the target's sensor could see
// take part, so that what lies beside the target's view finds no wrong partner at its edge.

#include <array>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/imaging/camera_model.hpp>

namespace lcmslam {

/// The pyramid that a camera sees, bounded by four planes through its centre.
class ViewFrustum {
 public:
  /// Of the ideal (undistorted) image. Corner rays a, b, c, d = upper left, upper right, lower right, lower
  /// left; outward normals b x a, d x c, a x d, c x b (eq. 3.5-3.10). Throws std::invalid_argument unless
  /// size and focal lengths are positive.
  explicit ViewFrustum(const CameraModel& camera);

  /// Point in the camera frame (x right, y down, z forward; m): inside all four planes (eq. 3.11). On a
  /// plane, at the centre, or not finite: outside.
  bool contains(const Eigen::Vector3f& point) const;

 private:
  std::array<Eigen::Vector3f, 4> outward_;
};

/// The points inside, in their order. With a merged target, `T_camera_cloud` leads to the camera of the last
/// registered cloud.
Cloud points_inside(const Cloud& cloud, const ViewFrustum& frustum, const Eigen::Isometry3d& T_camera_cloud);

}  // namespace lcmslam
