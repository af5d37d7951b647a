#include <lcmslam/calibration/self/surface_slopes.hpp>

#include <Eigen/LU>

namespace lcmslam {
namespace {

/// A patch's plane n p = 1 in the depth camera, at the moment of its middle row.
struct Plane {
  Comparison* compared;
  Eigen::Matrix3d R_world_depth;
  Eigen::Matrix2d rays_of_pixels;  // how rays (x, y) follow pixels there
  Eigen::Vector3d ray, n;
  double row_seconds;         // from a row to the next
  Eigen::Vector3d way, turn;  // the depth camera's velocity, its own frame

  Plane(Comparison* c, const BundleState& state, const CameraModel& camera,
        const Eigen::Isometry3d& T_depth_colour)
      : compared(c) {
    const HeadNumbers& h = state.model.values;
    const double seconds = residuals::seconds_to_depth(c->lag, c->row, h.data() + head::depth_scale);
    const Eigen::Matrix3d turned = so3_exp(-seconds * state.scene.keyframes[c->keyframe].twist.tail<3>());
    R_world_depth = (T_depth_colour.linear() * turned * state.starts[c->keyframe].linear()).transpose();
    const Eigen::Vector2d at(c->patch->u, c->patch->v), u(1, 0), v(0, 1);
    ray = camera.ray(at);
    rays_of_pixels << (camera.ray(at + u) - camera.ray(at - u)).head<2>() / 2,
        (camera.ray(at + v) - camera.ray(at - v)).head<2>() / 2;
    row_seconds = h[head::depth_rows] / camera.height;
    const Vector6d& twist = state.scene.keyframes[c->keyframe].twist;
    turn = T_depth_colour.linear() * twist.tail<3>();
    way = T_depth_colour.linear() * twist.head<3>() - turn.cross(T_depth_colour.translation());
    n = plane(0);
    n = plane(sheared(n));
  }

  /// Of the patch as it is but for `shear` of its slope along v.
  Eigen::Vector3d plane(double shear) const {
    const residuals::Patch& patch = *compared->patch;
    Eigen::Vector3d result;
    result.head<2>() =
        rays_of_pixels.transpose().inverse() * Eigen::Vector2d(patch.along_u, patch.along_v - shear);
    result.z() = patch.inverse - result.head<2>().dot(ray.head<2>());
    return result;
  }

  /// What the slope along v seems steeper by, as the camera moves from row to row: its frame p is
  /// p + seconds (way + turn x p) of the middle row's.
  double sheared(const Eigen::Vector3d& normal) const {
    return row_seconds * (normal.cross(turn).dot(ray) + normal.dot(way) * normal.dot(ray));
  }

  Eigen::Vector3d normal_in_world() const { return R_world_depth * n.normalized(); }

  /// Through the same depth, with this normal (world), unless that is seen from its edge.
  void take_slope(const Eigen::Vector3d& normal) {
    const Eigen::Vector3d seen = R_world_depth.transpose() * normal;
    const double facing = seen.dot(ray);
    if (!(facing > 0)) return;
    const Eigen::Vector3d there = seen * (compared->patch->inverse / facing);
    const Eigen::Vector2d along = rays_of_pixels.transpose() * there.head<2>();
    compared->patch->along_u = along.x(), compared->patch->along_v = along.y() + sheared(there);
  }
};

}  // namespace

void share_slopes(Comparison* first, Comparison* last, const BundleState& state, const CameraModel& camera,
                  const Eigen::Isometry3d& T_depth_colour) {
  constexpr double alike = 0.94;  // cosine of 20 degrees
  std::vector<Plane> planes;
  for (Comparison* c = first; c != last; ++c)
    if (c->patch) planes.emplace_back(c, state, camera, T_depth_colour);
  std::vector<Eigen::Vector3d> normals;
  for (const Plane& plane : planes) normals.push_back(plane.normal_in_world());
  for (std::size_t i = 0; i < planes.size(); ++i) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int agree = 0;
    for (std::size_t k = 0; k < planes.size(); ++k)
      if (k != i && normals[k].dot(normals[i]) > alike) sum += normals[k], ++agree;
    if (agree >= 2) planes[i].take_slope(sum.normalized());
  }
}

}  // namespace lcmslam
