// FastSlam: what the particles do in a step: move, weigh, learn, tell the pose, and are drawn again.

#include <algorithm>
#include <cmath>

#include <lcmslam/fastslam/fastslam.hpp>
#include <lcmslam/fastslam/pose_space.hpp>
#include <lcmslam/fastslam/resampling.hpp>
#include <lcmslam/parallel/rows.hpp>

namespace lcmslam {

// Calls work(begin, end) for parts of the particles, in parallel where `each` (landmarks a particle) makes it
// worth waking threads up. A particle's result depends on itself and its own random stream alone.
template <class Work>
void FastSlam::for_particles(std::size_t each, const Work& work) {
  const std::size_t count = particles_.size();
  if (count * each < 1000) return work(0, count);
  constexpr int part = 16;  // particles: the work is shared out as threads get free
  parallel_rows(0, static_cast<int>((count + part - 1) / part), [&](int first, int last) {
    work(static_cast<std::size_t>(first * part), std::min(count, static_cast<std::size_t>(last * part)));
  });
}

// Every particle draws its new pose, weighs it and updates its landmarks.
std::vector<FastSlam::Verdict> FastSlam::move_particles(const FrameAssociation& association,
                                                        const std::vector<LandmarkMatch>& observed,
                                                        const std::vector<FeaturePoint>& points) {
  std::vector<Verdict> verdicts(particles_.size());
  for_particles(observed.size(), [&](std::size_t begin, std::size_t end) {
    Workspace work;
    work.proposal = make_proposal(settings_, association.prior.covariance);
    for (const LandmarkMatch& match : observed)
      work.seen.measurements.push_back(points[static_cast<std::size_t>(match.point)].measurement);
    for (std::size_t first = begin; first < end; first += lane_count) {
      const std::size_t last = std::min(end, first + lane_count) - 1;
      Eigen::Isometry3d T_prior[lane_count];
      for (std::size_t lane = 0; lane < lane_count; ++lane) {
        const Particle& particle = particles_[std::min(first + lane, last)];
        T_prior[lane] = association.T_world_found ? *association.T_world_found
                        : association.corrected
                            ? particle.T_world_robot * association.prior.T_from_to
                            : particle.T_world_robot * calibration_.apply(particle.calibration);
      }
      move(&particles_[first], &streams_[first], static_cast<int>(last + 1 - first), T_prior, observed, work,
           &verdicts[first]);
      for (std::size_t k = first; k <= last && !association.corrected; ++k)
        calibration_.learn(se3_log(T_prior[k - first].inverse() * particles_[k].T_world_robot),
                           particles_[k].calibration);
    }
  });
  if (!association.corrected) calibration_.end();
  double highest = particles_[0].log_weight;
  for (const Particle& particle : particles_) highest = std::max(highest, particle.log_weight);
  for (Particle& particle : particles_) particle.log_weight -= highest;
  return verdicts;
}

// Up to four particles side by side; `T_world_prior` and lanes beyond `count` repeat the last one.
void FastSlam::move(Particle* particles, Random* streams, int count, const Eigen::Isometry3d* T_world_prior,
                    const std::vector<LandmarkMatch>& observed, Workspace& work, Verdict* verdicts) const {
  // Each particle's landmarks lie somewhere else in memory: all are on their way before the first is used.
  work.stored.clear();
  for (const LandmarkMatch& match : observed)
    for (int lane = 0; lane < lane_count; ++lane)
      work.stored.push_back(
          particles[std::min(lane, count - 1)].map.prefetch(static_cast<std::size_t>(match.slot)));
  load_landmarks(work.stored, work.seen.landmarks);
  ProposedPose proposed[lane_count];
  work.proposal->propose(T_world_prior, work.seen, streams, count, proposed);
  Eigen::Isometry3d T_world_robot[lane_count];
  for (int lane = 0; lane < lane_count; ++lane)
    T_world_robot[lane] = lane < count ? renormalised(proposed[lane].T_world_robot, settings_.planar)
                                       : T_world_robot[count - 1];
  const double added = settings_.minimum_landmark_sigma * settings_.minimum_landmark_sigma;
  learn_points(work.seen.measurements, work.seen.landmarks, T_world_robot, added, work.learned);
  for (int lane = 0; lane < count; ++lane) {
    particles[lane].T_world_robot = T_world_robot[lane];
    particles[lane].log_weight += proposed[lane].log_weight;
    learn(particles[lane], lane, observed, work, verdicts[lane]);
  }
}

// The particle weighs each observation, and believes those in its gate.
void FastSlam::learn(Particle& particle, int lane, const std::vector<LandmarkMatch>& observed,
                     const Workspace& work, Verdict& verdict) const {
  const double added = settings_.minimum_landmark_sigma * settings_.minimum_landmark_sigma;
  ParticleMap::Editor edit(particle.map);
  verdict.accepted.resize(observed.size());
  for (std::size_t i = 0; i < observed.size(); ++i) {
    const Measurement& measurement = work.seen.measurements[i];
    const auto slot = static_cast<std::size_t>(observed[i].slot);
    const auto weigh = [&](double distance2, double log_peak) {
      const bool accepted = distance2 <= gate2_;  // exp(-d^2/2) >= gate
      verdict.accepted[i] = accepted;
      if (accepted) {
        particle.log_weight += log_peak - 0.5 * distance2;  // log of 2.5, corrected
        ++verdict.count;
        verdict.distance2 += distance2;
      } else if (settings_.rejection == RejectionWeight::constant) {
        particle.log_weight += std::log(settings_.p0);
      } else {
        particle.log_weight += log_peak - 0.5 * gate2_;
      }
      return accepted;
    };
    if (measurement.kind == MeasurementKind::point) {
      const LearnedLanes& learned = work.learned[i];
      if (weigh(learned.distance2[lane], learned.log_peak(lane))) edit[slot] = learned.updated.landmark(lane);
    } else {
      const LandmarkGaussian landmark = work.seen.landmarks[i].gaussian(lane);
      const Innovation innovation = innovate(landmark, measurement, particle.T_world_robot);
      if (weigh(innovation.distance2, innovation.log_peak))
        edit[slot] = update_landmark(landmark, innovation, measurement, particle.T_world_robot, added);
    }
  }
}

void FastSlam::make_landmarks(const std::vector<LandmarkMatch>& created,
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

std::vector<double> FastSlam::weights() const {
  std::vector<double> logs;
  for (const Particle& particle : particles_) logs.push_back(particle.log_weight);
  return normalised_weights(logs);
}

std::vector<double> FastSlam::choose_best() {
  std::vector<double> weights = this->weights();
  best_ = static_cast<int>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  return weights;
}

Matrix6d FastSlam::scatter(const std::vector<Vector6d>& offsets, const std::vector<double>& weights,
                           const Vector6d& centre) {
  Matrix6d sum = Matrix6d::Zero();
  for (std::size_t k = 0; k < offsets.size(); ++k)
    sum += weights[k] * (offsets[k] - centre) * (offsets[k] - centre).transpose();
  return 0.5 * (sum + sum.transpose());  // exactly symmetric
}

void FastSlam::estimate(const std::vector<double>& weights, StepResult& result) const {
  result.T_world_best = particles_[best()].T_world_robot;
  const Eigen::Isometry3d T_best_world = result.T_world_best.inverse();
  std::vector<Vector6d> offsets(particles_.size());
  Vector6d mean = Vector6d::Zero();
  for (std::size_t k = 0; k < particles_.size(); ++k) {
    offsets[k] = se3_log(T_best_world * particles_[k].T_world_robot);
    mean += weights[k] * offsets[k];
  }
  if (settings_.estimate == PoseEstimate::best) mean.setZero();
  result.T_world_robot = result.T_world_best * se3_exp(mean);
  result.spread = scatter(offsets, weights, mean);
}

// Particles drawn from the whole path's posterior know where their paths began: their poses as seen from
// there lie about the estimate as the truth does. (The mean square about the estimate and not the variance:
// the smoother holds the world where it was said to be, not at the first pose.) Others have forgotten it, and
// what they share is added.
void FastSlam::tell_covariance(const std::vector<double>& weights, StepResult& result) const {
  if (!drawn_anew_) {
    result.covariance = result.spread + shared_error_.at(result.T_world_robot) + unmodelled_;
    return;
  }
  const Eigen::Isometry3d T_robot_world = result.T_world_robot.inverse();
  std::vector<Vector6d> offsets;
  for (const Particle& particle : particles_)
    offsets.push_back(se3_log(T_robot_world * particle.T_world_start.inverse() * particle.T_world_robot));
  result.covariance = scatter(offsets, weights, Vector6d::Zero()) + unmodelled_;
}

bool FastSlam::resample_when_due(const std::vector<double>& weights) {
  const double limit = settings_.resample_fraction * settings_.particles;
  const bool due = settings_.resample_fraction >= 1 || effective_sample_size(weights) < limit;
  if (due) resample_particles(weights);
  return due;
}

void FastSlam::resample_particles(const std::vector<double>& weights) {
  const std::vector<int> ancestors = resample(weights, settings_.resampling, resampling_stream_);
  std::vector<Particle> next(particles_.size());
  std::size_t heaviest = 0;
  for (std::size_t k = 0; k < next.size(); ++k) {
    const auto a = static_cast<std::size_t>(ancestors[k]);
    const bool last_copy = k + 1 == next.size() || ancestors[k + 1] != ancestors[k];
    if (last_copy)
      next[k] = std::move(particles_[a]);  // a map with one owner is changed in place
    else
      next[k] = particles_[a];
    next[k].log_weight = 0;
    if (weights[a] > weights[static_cast<std::size_t>(ancestors[heaviest])]) heaviest = k;
  }
  particles_ = std::move(next);
  best_ = static_cast<int>(heaviest);
}

}  // namespace lcmslam
