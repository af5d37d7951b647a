#include <lcmslam/dense_mapper/mount_error.hpp>

namespace lcmslam {

Matrix6d mount_error(const Eigen::Isometry3d& T_first_robot, const Eigen::Isometry3d& T_robot_camera,
                     const MountErrorSettings& settings) {
  if (T_robot_camera.translation().isZero()) return Matrix6d::Zero();
  const Matrix6d A = (Matrix6d::Identity() - adjoint(T_first_robot.inverse())) * adjoint(T_robot_camera);
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(settings.translation_sigma),
      Eigen::Vector3d::Constant(settings.rotation_sigma);
  const Matrix6d root = A * sigmas.asDiagonal();
  return root * root.transpose();
}

}  // namespace lcmslam
