#include <lcmslam/geometry/mount_error.hpp>

namespace lcmslam {

Vector6d MountErrorSettings::sigmas(const Eigen::Isometry3d& T_robot_camera) const {
  if (T_robot_camera.translation().isZero()) return Vector6d::Zero();
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(translation_sigma), Eigen::Vector3d::Constant(rotation_sigma);
  return sigmas;
}

Matrix6d mount_lever(const Eigen::Isometry3d& T_first_now) {
  return Matrix6d::Identity() - adjoint(T_first_now.inverse());
}

Matrix6d mount_error(const Eigen::Isometry3d& T_first_now, const Eigen::Isometry3d& T_robot_camera,
                     const Vector6d& sigmas, const Matrix6d& moved) {
  const Matrix6d root = adjoint(T_robot_camera) * (moved - mount_lever(T_first_now) * sigmas.asDiagonal());
  return root * root.transpose();
}

}  // namespace lcmslam
