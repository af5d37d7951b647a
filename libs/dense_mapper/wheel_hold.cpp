#include <lcmslam/dense_mapper/wheel_hold.hpp>

#include <lcmslam/dense_mapper/motion_prior.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

bool WheelHold::is_accompanied(const PreparedFrame& prepared, bool adrift) {
  const auto& motion = prepared.frame.motion;
  if (motion && !motion->visual && !adrift)
    companion_.observe(prepared.cloud, *motion);
  else
    companion_.end();
  return companion_.there();
}

void WheelHold::hold(const PreparedFrame& prepared, const Expectation& expected, Tracked& tracked) {
  RegistrationResult& registration = tracked.registration;
  const bool lost = tracked.status == MappingStatus::lost;
  if (prepared.accompanied) {
    way_.begin();
    tracked.held = tracked.status != MappingStatus::tracking;
    if (lost) registration.T_target_source = tracked.prior.T_target_source;
    if (lost) registration.covariance = uncertain(tracked.prior);
  } else if (lost || expected.adrift || tracked.pushed || !registration.settled) {
    return way_.begin();
  } else if (const auto T_held = way_.observe(*prepared.frame.motion, expected.prior.T_target_source,
                                              registration, tracked.anchored)) {
    const Vector6d led = se3_log(T_held->inverse() * registration.T_target_source);
    registration.T_target_source = *T_held;
    registration.covariance = uncertain(expected.prior) + led * led.transpose();
    tracked.held = true;
    if (!expected.T_world_stood) companion_.begin(prepared.cloud);
  }
  if (tracked.held) tracked.status = MappingStatus::degraded;
}

}  // namespace lcmslam
