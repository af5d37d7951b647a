// ParticleSet: a step of the filter, by all particles in parallel.

#include <algorithm>
#include <cmath>

#include <lcmslam/fastslam/particle_set.hpp>
#include <lcmslam/fastslam/particle_update.hpp>
#include <lcmslam/fastslam/pose_space.hpp>
#include <lcmslam/parallel/rows.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t landmarks_worth_threads = 1000;  // in all particles together
constexpr std::size_t particles_at_once = 16;          // the work is shared out as threads get free

}  // namespace

// Calls work(begin, end) for parts of the particles, in parallel where `each` (landmarks a particle) makes it
// worth waking threads up.
template <class Work>
void ParticleSet::for_particles(std::size_t each, const Work& work) {
  const std::size_t count = particles_.size();
  if (count * each < landmarks_worth_threads) return work(0, count);
  const auto parts = static_cast<int>((count + particles_at_once - 1) / particles_at_once);
  parallel_rows(0, parts, [&](int first, int last) {
    work(static_cast<std::size_t>(first) * particles_at_once,
         std::min(count, static_cast<std::size_t>(last) * particles_at_once));
  });
}

Motion ParticleSet::predict(const Motion& odometry) {
  Motion prior = odometry;
  calibration_.begin(prior);
  prior.T_from_to = calibration_.apply(best().calibration);
  if (!undrawn_.isZero(0)) {
    const Matrix6d A = adjoint(prior.T_from_to.inverse());
    prior.covariance += A * undrawn_ * A.transpose();
  }
  calibration_.prepare_gain(prior.covariance);
  prior.covariance += calibration_.added_covariance();
  return prior;
}

void ParticleSet::go_blindly(const StepPrior& prior) {
  for (Particle& particle : particles_)
    particle.T_world_robot = renormalised(T_world_prior(particle, prior), settings_.planar);
  const Matrix6d symmetric = 0.5 * (prior.covariance + prior.covariance.transpose());
  undrawn_ = settings_.planar ? PoseSpace<3>::expand(PoseSpace<3>::reduce(symmetric)) : symmetric;
}

Eigen::Isometry3d ParticleSet::T_world_prior(const Particle& particle, const StepPrior& prior) const {
  if (prior.T_world_robot) return *prior.T_world_robot;
  if (prior.T_from_to) return particle.T_world_robot * *prior.T_from_to;
  const Eigen::Isometry3d T = particle.T_world_robot * calibration_.apply(particle.calibration);
  return prior.ground ? (*prior.ground)(T) : T;
}

Verdict ParticleSet::propose_weigh_update(const StepPrior& prior, const std::vector<LandmarkMatch>& observed,
                                          const std::vector<FeaturePoint>& points) {
  std::vector<Verdict> verdicts(particles_.size());
  for_particles(observed.size(), [&](std::size_t begin, std::size_t end) {
    ParticleUpdate update(settings_, prior.covariance, observed, points);
    for (std::size_t first = begin; first < end; first += lane_count) {
      const std::size_t last = std::min(end, first + lane_count) - 1;
      Eigen::Isometry3d T_prior[lane_count];
      for (std::size_t lane = 0; lane < lane_count; ++lane)
        T_prior[lane] = T_world_prior(particles_[std::min(first + lane, last)], prior);
      update.apply(&particles_[first], &streams_[first], static_cast<int>(last + 1 - first), T_prior,
                   &verdicts[first]);
      for (std::size_t k = first; k <= last && !prior.corrected(); ++k)
        calibration_.learn(se3_log(T_prior[k - first].inverse() * particles_[k].T_world_robot),
                           particles_[k].calibration);
    }
  });
  if (!prior.corrected()) calibration_.end();
  undrawn_.setZero();
  std::size_t heaviest = 0;
  for (std::size_t k = 1; k < particles_.size(); ++k)
    if (particles_[heaviest].log_weight < particles_[k].log_weight) heaviest = k;
  const double highest = particles_[heaviest].log_weight;
  for (Particle& particle : particles_) particle.log_weight -= highest;
  return std::move(verdicts[heaviest]);
}

void ParticleSet::make_landmarks(const std::vector<LandmarkMatch>& created,
                                 const std::vector<FeaturePoint>& points) {
  std::vector<Measurement> measurements;
  for (const LandmarkMatch& match : created)
    measurements.push_back(points[static_cast<std::size_t>(match.point)].measurement);
  for_particles(created.size(), [&](std::size_t begin, std::size_t end) {
    std::vector<CompactLanes> made;
    for (std::size_t first = begin; first < end; first += lane_count) {
      Eigen::Isometry3d T_world_robot[lane_count];
      for (std::size_t lane = 0; lane < lane_count; ++lane)
        T_world_robot[lane] = particles_[std::min(first + lane, end - 1)].T_world_robot;
      for (std::size_t k = first; k < std::min(end, first + lane_count); ++k)
        for (const LandmarkMatch& match : created)
          particles_[k].map.prefetch(static_cast<std::size_t>(match.slot));
      make_points(measurements, T_world_robot, made);
      for (std::size_t k = first; k < std::min(end, first + lane_count); ++k) {
        ParticleMap::Editor edit(particles_[k].map);
        for (std::size_t i = 0; i < created.size(); ++i)
          edit[static_cast<std::size_t>(created[i].slot)] =
              measurements[i].kind == MeasurementKind::point
                  ? made[i].landmark(static_cast<int>(k - first))
                  : CompactLandmark(make_landmark(measurements[i], particles_[k].T_world_robot));
      }
    }
  });
}

}  // namespace lcmslam
