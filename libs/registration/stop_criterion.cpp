#include <lcmslam/registration/stop_criterion.hpp>

#include <cmath>

namespace lcmslam {

bool StopCriterion::arrived(const Eigen::Isometry3d& before, const Eigen::Isometry3d& after,
                            const std::vector<double>& rms) const {
  const Eigen::Isometry3d step = before.inverse() * after;
  if (step.translation().norm() < settings_.epsilon_translation &&
      rotation_angle(step) < settings_.epsilon_rotation)
    return true;
  const std::size_t n = rms.size();
  return n >= 2 && std::abs(rms[n - 1] - rms[n - 2]) < settings_.epsilon_rms;
}

}  // namespace lcmslam
