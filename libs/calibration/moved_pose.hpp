#pragma once
// A pose as Ceres refines it: a start, moved by a step that begins at zero. The step's axes are the start's:
// its covariance is that of the pose, T exp(xi), where the step stays so small that both poses have the same
// ones.

#include <ceres/rotation.h>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

using PoseStep = std::array<double, 6>;  ///< translation (m), rotation (rad), frame of the pose's source

template <class T>
struct MovedPose {
  Eigen::Matrix<T, 3, 3> R;
  Eigen::Matrix<T, 3, 1> t;

  MovedPose(const Eigen::Isometry3d& start, const T* step) {
    Eigen::Matrix<T, 3, 3> turn;  // column-major, as Ceres writes it
    ceres::AngleAxisToRotationMatrix(step + 3, turn.data());
    R = start.linear().cast<T>() * turn;
    t = start.linear().cast<T>() * Eigen::Map<const Eigen::Matrix<T, 3, 1>>(step) +
        start.translation().cast<T>();
  }
  Eigen::Matrix<T, 3, 1> operator*(const Eigen::Matrix<T, 3, 1>& p) const { return R * p + t; }
  Eigen::Matrix<T, 3, 1> inverse_of(const Eigen::Matrix<T, 3, 1>& p) const { return R.transpose() * (p - t); }
};

inline Eigen::Isometry3d moved(const Eigen::Isometry3d& start, const PoseStep& step) {
  const MovedPose<double> pose(start, step.data());
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(pose.R).normalized().toRotationMatrix();
  T.translation() = pose.t;
  return T;
}

}  // namespace lcmslam
