#pragma once
#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/registration.hpp>

namespace lcmslam {

inline RegistrationResult register_to_itself(const Cloud& cloud, const Eigen::Isometry3d& start,
                                             const Prior* prior = nullptr) {
  const RegistrationSettings settings;
  return register_cloud(cloud, KdTreeTarget(cloud), start, settings, prior);
}

}  // namespace lcmslam
