#include <lcmslam/fastslam/motion_model.hpp>

#include <cmath>

#include <lcmslam/fastslam/pose_space.hpp>

namespace lcmslam {
namespace {

double squared(double x) {
  return x * x;
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

Motion unknown_motion(Utime elapsed) {
  const double seconds = 1e-6 * static_cast<double>(elapsed);
  Motion motion;
  motion.covariance.diagonal().head<3>().setConstant(std::pow(0.5 * seconds, 2));
  motion.covariance.diagonal().tail<3>().setConstant(std::pow(1.0 * seconds, 2));
  return motion;
}

}  // namespace lcmslam
