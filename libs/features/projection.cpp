#include <lcmslam/features/projection.hpp>

namespace lcmslam {

std::optional<Projection> project(const MapPoint& point, const Eigen::Isometry3d& T_world_camera,
                                  const FeatureFrame& frame) {
  constexpr double nearest = 0.1;  // m
  const Eigen::Matrix3d R_camera_world = T_world_camera.linear().transpose();
  const Eigen::Vector3d p = R_camera_world * (point.position - T_world_camera.translation());
  if (!p.allFinite() || p.z() < nearest) return std::nullopt;
  const double u = p.x() / p.z(), v = p.y() / p.z();
  Eigen::Matrix<double, 2, 3> by_p;
  by_p << frame.fx, 0, -frame.fx * u, 0, frame.fy, -frame.fy * v;
  by_p /= p.z();
  Projection projection;
  projection.pixel = {frame.fx * u + frame.cx, frame.fy * v + frame.cy};
  projection.by_pose << -by_p, by_p * hat(p);
  projection.by_point = by_p * R_camera_world;
  return projection;
}

Eigen::Matrix2d innovation_covariance(const Projection& projection, const MapPoint& point,
                                      const PredictedPose& pose, const FeatureFrame& frame) {
  return projection.by_pose * pose.covariance * projection.by_pose.transpose() +
         projection.by_point * point.covariance * projection.by_point.transpose() +
         frame.pixel_sigma * frame.pixel_sigma * Eigen::Matrix2d::Identity();
}

}  // namespace lcmslam
