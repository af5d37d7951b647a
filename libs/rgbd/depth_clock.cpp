#include <lcmslam/rgbd/depth_clock.hpp>

#include <cmath>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {

DepthClock::DepthClock(const DepthClockSettings& settings) : settings_(settings) {
  check(settings_, "depth clock");
}

// The cloud is truly of offset + d: it was moved too little by omega d, and what is seen is
// exp(omega d) = T_world_features^-1 T_world_cloud.
void DepthClock::add(const Eigen::Isometry3d& T_world_features, const Eigen::Isometry3d& T_world_cloud,
                     const Eigen::Vector3d& omega) {
  if (!settings_.enabled) return;
  const Eigen::Vector3d turn = so3_log(T_world_features.linear().transpose() * T_world_cloud.linear());
  if (!(turn.norm() < settings_.outlier) || !omega.allFinite()) return;
  const double weight = 1 / (settings_.noise * settings_.noise);
  information_ += weight * omega.squaredNorm();
  sum_ += weight * omega.dot(turn + offset_ * omega);
  offset_ = sum_ / (information_ + 1 / (settings_.prior * settings_.prior));
}

double DepthClock::sigma() const {
  return 1 / std::sqrt(information_ + 1 / (settings_.prior * settings_.prior));
}

}  // namespace lcmslam
