#include <lcmslam/fastslam/motion_model.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/fastslam/pose_space.hpp>

namespace lcmslam {
namespace {

constexpr Utime longest_blink = 600'000;   // us: 0.3 m and 0.6 rad, much of what was seen is still in view
constexpr Utime longest_gap = 60'000'000;  // us: after it a robot may be anywhere, and nobody states more

double squared(double x) {
  return x * x;
}

// Whether the stated error of a block of the motion exceeds both the motion and what the speed bounds anyway.
bool knows_nothing(const Eigen::Vector3d& variances, double moved, double bound2) {
  return variances.maxCoeff() >= 0.99 * std::max(bound2, squared(moved));
}

}  // namespace

bool usable(const Motion& motion) {
  return motion.T_from_to.matrix().allFinite() && motion.covariance.allFinite() &&
         motion.covariance.diagonal().minCoeff() >= 0 && motion.covariance.diagonal().maxCoeff() < 1e6 &&
         std::abs(motion.T_from_to.linear().determinant() - 1) < 1e-3;
}

Motion motion_prior(const Motion& odometry, const FastSlamSettings& s) {
  Motion prior;
  prior.visual = odometry.visual;
  if (!usable(odometry)) {
    prior.covariance.diagonal().setConstant(squared(0.5));
    return prior;
  }
  prior.T_from_to = restrict_pose(odometry.T_from_to, s.planar);
  if (s.use_motion_covariance) {
    const double factor = odometry.visual ? squared(s.visual_factor) : 1;
    prior.covariance = 0.5 * factor * (odometry.covariance + odometry.covariance.transpose());
  }
  const double distance = prior.T_from_to.translation().norm();
  const double angle = rotation_angle(prior.T_from_to);
  prior.covariance.diagonal().head<3>().array() +=
      squared(s.translation_noise) + squared(s.translation_noise_per_m * distance);
  prior.covariance.diagonal().tail<3>().array() += squared(s.rotation_noise) +
                                                   squared(s.rotation_noise_per_rad * angle) +
                                                   squared(s.rotation_noise_per_m * distance);
  return prior;
}

Motion with_ground(Motion motion, const FastSlamSettings& s) {
  if (!s.left_plane) return motion;
  const double distance = motion.T_from_to.translation().norm();
  motion.covariance(2, 2) += squared(s.ground_rise_per_m * distance);
  motion.covariance.diagonal().segment<2>(3).array() += squared(s.ground_tilt_per_m * distance);
  return motion;
}

bool UnknownMotion::knows(const Motion& odometry, Utime step) const {
  if (!usable(odometry)) return false;
  if (step == 0) return true;
  const Matrix6d bound = unknown_motion(step).covariance;
  const Vector6d told = odometry.covariance.diagonal();
  const bool no_way = knows_nothing(told.head<3>(), odometry.T_from_to.translation().norm(), bound(0, 0));
  const bool no_turn = knows_nothing(told.tail<3>(), rotation_angle(odometry.T_from_to), bound(5, 5));
  // A visual odometry in the dark states no more error of its turn once that may be any: what it still knows
  // of one is no news.
  return elapsed_ > 0 ? !no_way && !no_turn : !no_way || !no_turn;
}

Motion UnknownMotion::prior(const Motion& odometry, Utime utime) {
  const Utime step = last_ ? std::clamp<Utime>(utime - *last_, 0, longest_gap) : 0;
  last_ = utime;
  before_ = elapsed_;
  if (knows(odometry, step)) return step_ = motion_prior(odometry, settings_);
  const Matrix6d before = unknown_motion(elapsed_).covariance;
  elapsed_ += step;
  Motion standing = motion_prior(Motion(), settings_);
  step_ = standing;
  step_.covariance += unknown_motion(step).covariance;
  standing.covariance += unknown_motion(elapsed_).covariance - before;
  return standing;
}

// One step of a slow camera without odometry may be longer than lost_after: that the robot knows nothing of
// what it sees shows only when it has looked.
Whereabouts UnknownMotion::whereabouts() const {
  if (!lost()) return Whereabouts::predicted;
  return before_ == 0 && elapsed_ <= longest_blink ? Whereabouts::near : Whereabouts::anywhere;
}

}  // namespace lcmslam
