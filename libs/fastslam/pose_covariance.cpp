#include <lcmslam/fastslam/pose_covariance.hpp>

namespace lcmslam {

PoseCovariance::PoseCovariance(const FastSlamSettings& settings)
    : sensor_error_(settings), ensemble_(settings) {
  const double translation = settings.shared_translation_sigma, rotation = settings.shared_rotation_sigma;
  unmodelled_.diagonal().head<3>().setConstant(translation * translation);
  unmodelled_.diagonal().tail<3>().setConstant(rotation * rotation);
}

std::vector<EnsembleObservation> PoseCovariance::with_errors(const std::vector<LandmarkMatch>& matches,
                                                             const MeasuredStep& step) {
  std::vector<EnsembleObservation> observations;
  observations.reserve(matches.size());
  for (const LandmarkMatch& match : matches) {
    const FeaturePoint& point = step.points[static_cast<std::size_t>(match.point)];
    observations.push_back({match.slot, point.measurement,
                            *step.map.find(static_cast<std::size_t>(match.slot)),
                            sensor_error_.draw(point, step.frame, step.index.record(match.slot).id,
                                               step.T_world_robot, step.twist)});
  }
  return observations;
}

void PoseCovariance::observe(const std::vector<LandmarkMatch>& accepted, const MeasuredStep& step,
                             const std::optional<Matrix6d>& prior) {
  ensemble_.observe(with_errors(accepted, step), step.T_world_robot, prior);
}

void PoseCovariance::create(const std::vector<LandmarkMatch>& created, const MeasuredStep& step) {
  ensemble_.create(with_errors(created, step), step.T_world_robot);
}

// Particles drawn from the whole path's posterior know where their paths began: their poses as seen from
// there lie about the estimate as the truth does. (The mean square about the estimate and not the variance:
// the smoother holds the world where it was published to be, not at the first pose.) Others have forgotten
// it, and the ensemble remembers.
Matrix6d PoseCovariance::from_start(const ParticleSet& particles, const std::vector<double>& weights,
                                    const ParticleSet::Estimate& estimate) const {
  if (particles.start_known())
    return particles.mean_square_from_start(weights, estimate.T_world_robot) + unmodelled_;
  return ensemble_.pose() + unmodelled_;
}

Eigen::Matrix3d PoseCovariance::of_landmark(int slot, const ParticleSet& particles) const {
  return particles.start_known() ? particles.mean_square_from_start(slot) : ensemble_.landmark(slot);
}

}  // namespace lcmslam
