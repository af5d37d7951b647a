#include <lcmslam/dense_mapper/registration_passes.hpp>

namespace lcmslam {
namespace {

constexpr double kept_in_recovery = 0.1;  // of the prior's information

// Wheels tell the way where all is new. Without them what is new must, too, and whatever moves leads.
RegistrationSettings fitted_to(const PreparedFrame& prepared, RegistrationSettings pass) {
  const auto& motion = prepared.frame.motion;
  pass.settled_lead = motion && !motion->visual;
  pass.settled_alone = prepared.accompanied;
  return pass;
}

/// Closed-form estimators know no prior: for them odometry is only the start.
const Prior* prior_for(const RegistrationSettings& settings, const Prior& prior) {
  return is_iterative(settings.solver) ? &prior : nullptr;
}

}  // namespace

RegistrationPasses::Attempt RegistrationPasses::run(const PreparedFrame& prepared, const Target& target,
                                                    const Eigen::Isometry3d& T_start, const Prior& prior,
                                                    const LastView& last) const {
  const bool recovery = is_beyond(T_start, prior);
  Prior used = prior;
  if (recovery) {
    used.T_target_source = T_start;
    used.information *= kept_in_recovery;
  }
  Attempt result;
  Eigen::Isometry3d T = T_start;
  for (const RegistrationSettings* pass : {&settings_.coarse, &settings_.fine}) {
    result.registration = register_cloud(prepared.cloud, target, T, last.possible(fitted_to(prepared, *pass)),
                                         prior_for(*pass, used), last.views(),
                                         pass == &settings_.fine ? prepared.frame.noise_left : 1);
    T = result.registration.T_target_source;
  }
  result.quality = result.registration.overlap * inlier_share(result.registration);
  result.status = judge(result.registration, used);
  if (recovery && result.status == MappingStatus::degraded) result.status = MappingStatus::lost;
  return result;
}

bool RegistrationPasses::is_beyond(const Eigen::Isometry3d& T_world_robot, const Prior& prior) const {
  return distance_between(T_world_robot, prior.T_target_source) > settings_.max_jump ||
         angle_between(T_world_robot, prior.T_target_source) > settings_.max_turn;
}

MappingStatus RegistrationPasses::judge(const RegistrationResult& result, const Prior& prior) const {
  if (!result.ok() || result.overlap < settings_.lost_overlap) return MappingStatus::lost;
  if (is_beyond(result.T_target_source, prior)) return MappingStatus::lost;
  if (result.overlap < settings_.good_overlap || inlier_share(result) < settings_.good_inliers)
    return MappingStatus::degraded;
  return MappingStatus::tracking;
}

}  // namespace lcmslam
