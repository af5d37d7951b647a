#include <lcmslam/rgbd/depth_clock.hpp>

#include <cmath>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {

DepthClock::DepthClock(const DepthClockSettings& settings)
    : settings_(settings), variance_(settings.noise * settings.noise) {
  check(settings_, "depth clock");
}

// The cloud is truly of added + d: it was moved too little by omega d, and what is seen is
// exp(omega d) = T_world_features^-1 T_world_cloud.
void DepthClock::add(const Eigen::Isometry3d& T_world_features, const Eigen::Isometry3d& T_world_cloud,
                     const Eigen::Vector3d& omega, double added) {
  if (!settings_.enabled) return;
  const Eigen::Vector3d seen = so3_log(T_world_features.linear().transpose() * T_world_cloud.linear());
  if (!(seen.norm() < settings_.outlier) || !omega.allFinite()) return;
  const Eigen::Vector3d turn = seen + added * omega;
  ++frames_;
  omega_omega_ += omega.squaredNorm();
  omega_turn_ += omega.dot(turn);
  turn_turn_ += turn.squaredNorm();
  offset_ = omega_turn_ / (settings_.frames_alike * variance_ * information());
  const double left = turn_turn_ - 2 * offset_ * omega_turn_ + offset_ * offset_ * omega_omega_;
  const double stated = settings_.stated_frames * settings_.noise * settings_.noise;
  variance_ = (stated + left / 3) / (settings_.stated_frames + frames_);
}

double DepthClock::information() const {
  return omega_omega_ / (settings_.frames_alike * variance_) + 1 / (settings_.prior * settings_.prior);
}

double DepthClock::sigma() const {
  return 1 / std::sqrt(information());
}

}  // namespace lcmslam
