#include <lcmslam/fastslam/pose_covariance.hpp>

namespace lcmslam {

PoseCovariance::PoseCovariance(const FastSlamSettings& settings)
    : minimum_consensus_(settings.minimum_consensus) {
  const double translation = settings.shared_translation_sigma, rotation = settings.shared_rotation_sigma;
  unmodelled_.diagonal().head<3>().setConstant(translation * translation);
  unmodelled_.diagonal().tail<3>().setConstant(rotation * rotation);
}

// Particles drawn from the whole path's posterior know where their paths began: their poses as seen from
// there lie about the estimate as the truth does. (The mean square about the estimate and not the variance:
// the smoother holds the world where it was published to be, not at the first pose.) Others have forgotten
// it, and what they share is added.
Matrix6d PoseCovariance::from_start(const ParticleSet& particles, const std::vector<double>& weights,
                                    const ParticleSet::Estimate& estimate) const {
  if (particles.start_known())
    return particles.mean_square_from_start(weights, estimate.T_world_robot) + unmodelled_;
  return estimate.spread + shared_error_.at(estimate.T_world_robot) + unmodelled_;
}

}  // namespace lcmslam
