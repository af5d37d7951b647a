#include <lcmslam/registration/view_frustum.hpp>

#include <stdexcept>

namespace lcmslam {

ViewFrustum::ViewFrustum(const CameraModel& camera) {
  if (!(camera.width > 0 && camera.height > 0 && camera.fx > 0 && camera.fy > 0))
    throw std::invalid_argument("view frustum: the camera has no positive size and focal lengths");
  // Borders of the image, half a pixel outside the centres of its border pixels.
  const auto ray = [&](double x, double y) {
    return Eigen::Vector3f(
        Eigen::Vector3d((x - 0.5 - camera.cx) / camera.fx, (y - 0.5 - camera.cy) / camera.fy, 1)
            .cast<float>());
  };
  const double right = camera.width, bottom = camera.height;
  const Eigen::Vector3f a = ray(0, 0), b = ray(right, 0), c = ray(right, bottom), d = ray(0, bottom);
  outward_ = {b.cross(a), d.cross(c), a.cross(d), c.cross(b)};
}

bool ViewFrustum::contains(const Eigen::Vector3f& point) const {
  for (const Eigen::Vector3f& normal : outward_)
    if (!(normal.dot(point) < 0)) return false;
  return true;
}

Cloud points_inside(const Cloud& cloud, const ViewFrustum& frustum, const Eigen::Isometry3d& T_camera_cloud) {
  const Eigen::Isometry3f T = T_camera_cloud.cast<float>();
  return kept_points(cloud, [&](std::size_t i) { return frustum.contains(T * cloud.points[i]); });
}

}  // namespace lcmslam
