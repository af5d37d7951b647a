#include <lcmslam/fastslam/particle_update.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/fastslam/pose_space.hpp>

namespace lcmslam {

ParticleUpdate::ParticleUpdate(const FastSlamSettings& settings, const Matrix6d& motion_covariance,
                               const std::vector<LandmarkMatch>& observed,
                               const std::vector<FeaturePoint>& points)
    : settings_(settings),
      observed_(observed),
      gate2_(-2 * std::log(settings.gate)),
      added_variance_(settings.minimum_landmark_sigma * settings.minimum_landmark_sigma),
      proposal_(make_proposal(settings, motion_covariance)) {
  for (const LandmarkMatch& match : observed)
    seen_.measurements.push_back(points[static_cast<std::size_t>(match.point)].measurement);
}

void ParticleUpdate::apply(Particle* particles, Random* streams, int count,
                           const Eigen::Isometry3d* T_world_prior, Verdict* verdicts) {
  load_maps(particles, count);

  // Propose.
  ProposedPose proposed[lane_count];
  proposal_->propose(T_world_prior, seen_, streams, count, proposed);
  Eigen::Isometry3d T_world_robot[lane_count];
  for (int lane = 0; lane < lane_count; ++lane)
    T_world_robot[lane] = lane < count ? renormalised(proposed[lane].T_world_robot, settings_.planar)
                                       : T_world_robot[count - 1];

  // What each would learn from there, of which it then believes what lies in its gate.
  learn_points(seen_.measurements, seen_.landmarks, T_world_robot, added_variance_, learned_);

  // Weigh and update.
  for (int lane = 0; lane < count; ++lane) {
    particles[lane].T_world_robot = T_world_robot[lane];
    particles[lane].log_weight += proposed[lane].log_weight;
    weigh_and_update(particles[lane], lane, verdicts[lane]);
  }
}

// Each particle's landmarks lie somewhere else in memory: all are on their way before the first is used.
void ParticleUpdate::load_maps(const Particle* particles, int count) {
  stored_.clear();
  for (const LandmarkMatch& match : observed_)
    for (int lane = 0; lane < lane_count; ++lane)
      stored_.push_back(
          particles[std::min(lane, count - 1)].map.prefetch(static_cast<std::size_t>(match.slot)));
  load_landmarks(stored_, seen_.landmarks);
}

void ParticleUpdate::weigh_and_update(Particle& particle, int lane, Verdict& verdict) const {
  ParticleMap::Editor edit(particle.map);
  verdict.accepted.resize(observed_.size());
  for (std::size_t i = 0; i < observed_.size(); ++i) {
    const Measurement& measurement = seen_.measurements[i];
    const auto slot = static_cast<std::size_t>(observed_[i].slot);
    bool accepted = false;
    if (measurement.kind == MeasurementKind::point) {
      const LearnedLanes& learned = learned_[i];
      accepted = weigh(learned.distance2[lane], learned.log_peak(lane), particle.log_weight, verdict);
      if (accepted) edit[slot] = learned.updated.landmark(lane);
    } else {
      const LandmarkGaussian landmark = seen_.landmarks[i].gaussian(lane);
      const Innovation innovation = innovate(landmark, measurement, particle.T_world_robot);
      accepted = weigh(innovation.distance2, innovation.log_peak, particle.log_weight, verdict);
      if (accepted)
        edit[slot] =
            update_landmark(landmark, innovation, measurement, particle.T_world_robot, added_variance_);
    }
    verdict.accepted[i] = accepted;
  }
}

// Log of (2.5), corrected. Whether the observation lies in the gate: exp(-d^2/2) >= gate.
bool ParticleUpdate::weigh(double distance2, double log_peak, double& log_weight, Verdict& verdict) const {
  const bool accepted = distance2 <= gate2_;
  if (accepted) {
    log_weight += log_peak - 0.5 * distance2;
    ++verdict.count;
    verdict.distance2 += distance2;
  } else if (settings_.rejection == RejectionWeight::constant) {
    log_weight += std::log(settings_.p0);
  } else {
    log_weight += log_peak - 0.5 * gate2_;
  }
  return accepted;
}

}  // namespace lcmslam
