#include "fastslam/fastslam.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "fastslam/existence.hpp"
#include "fastslam/motion_model.hpp"
#include "fastslam/pose_space.hpp"
#include "fastslam/proposal.hpp"
#include "fastslam/resampling.hpp"
#include "surf/kernel_set.hpp"

namespace lcmslam {
namespace {

constexpr std::uint64_t kResamplingStream = 0x726573616d706c65;
constexpr std::uint64_t kSmoothingStream = 0x736d6f6f7468;

FastSlamSettings checked(const FastSlamSettings& settings) {
  check(settings);
  return settings;
}

void sort_by_slot(std::vector<LandmarkMatch>& matches) {
  std::sort(matches.begin(), matches.end(),
            [](const LandmarkMatch& a, const LandmarkMatch& b) { return a.slot < b.slot; });
}

void report(const std::vector<LandmarkMatch>& matches, AssociationOutcome outcome,
            const std::vector<FeaturePoint>& points, const LandmarkIndex& index, StepResult& result) {
  for (const LandmarkMatch& match : matches)
    result.associations.push_back(
        {points[static_cast<std::size_t>(match.point)].feature, index.record(match.slot).id, outcome});
}

// `seen` and `observed` are ordered by slot, and `seen` holds all of `observed`.
void report_observations(const std::vector<LandmarkMatch>& observed, const std::vector<LandmarkMatch>& seen,
                         const std::vector<LandmarkMatch>& mistaken, const std::vector<char>& accepted,
                         const std::vector<FeaturePoint>& points, const LandmarkIndex& index,
                         StepResult& result) {
  std::size_t next = 0;
  for (const LandmarkMatch& match : seen) {
    AssociationOutcome outcome = AssociationOutcome::unused;
    if (next < observed.size() && observed[next].slot == match.slot)
      outcome = accepted[next++] ? AssociationOutcome::accepted : AssociationOutcome::rejected;
    report({match}, outcome, points, index, result);
  }
  report(mistaken, AssociationOutcome::rejected, points, index, result);
}

void widen(double factor, Measurement& measurement) {
  const int n = measurement.kind == MeasurementKind::point ? 3 : 2;
  measurement.covariance.topLeftCorner(n, n) *= factor;
}

}  // namespace

FastSlam::FastSlam(const FastSlamSettings& settings)
    : settings_(checked(settings)),
      gate2_(-2 * std::log(settings.gate)),
      particles_(static_cast<std::size_t>(settings.particles)),
      resampling_stream_(settings.seed, kResamplingStream),
      associator_(settings),
      calibration_(settings),
      smoothing_stream_(settings.seed, kSmoothingStream),
      publication_(settings.minimum_observations) {
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    streams_.emplace_back(settings.seed, i);
    particles_[i].lineage = static_cast<int>(i);
  }
  if (settings.rejuvenate && settings.planar) smoother_ = std::make_unique<PathSmoother>(settings);
  if (settings.smooth_map) map_smoother_ = std::make_unique<MapSmoother>(settings);
}

StepResult FastSlam::step(const Motion& motion, const FeatureFrame& frame) {
  StepResult result;
  if (running_ && frame.utime >= running_->due) {
    auto path = take_over(running_->result.get());
    if (running_->wanted) taken_over_ = std::move(path);
    running_.reset();
  }
  if (running_path_ && frame.utime >= running_path_->due) result.rejuvenated = take_over_path();
  last_utime_ = frame.utime;
  std::vector<FeaturePoint> points = usable_features(frame, settings_);
  result.offered = static_cast<int>(
      std::count_if(points.begin(), points.end(), [](const FeaturePoint& p) { return !p.is_bearing(); }));
  const std::vector<FeaturePoint> measured = smoother_ ? points : std::vector<FeaturePoint>();
  for (FeaturePoint& point : points) point.measurement = sensor_.corrected(point.measurement);

  // Old landmarks first: associate, then move, weigh and update every particle.
  std::vector<LandmarkMatch> seen;
  std::vector<VisibleLandmark> expected;
  bool may_create = true;
  std::vector<int> contradicted;
  observed_.clear();
  if (started_) seen = filter(motion, frame, points, expected, contradicted, may_create, result);
  started_ = true;
  // The particle of highest weight is the map; the pose is estimated before resampling adds noise.
  const std::vector<double> weights = choose_best();
  estimate(weights, result);
  const bool reunion =
      !contradicted.empty() || std::any_of(seen.begin(), seen.end(), [&](const LandmarkMatch& match) {
        return index_.unseen_steps(match.slot) > settings_.reunion_steps;
      });

  // Landmarks die and are born alike in all particles; new ones last, so that 2.0 is possible.
  result.removed = update_existence(index_, particles_[best()].map, frame, points, expected, seen,
                                    contradicted, particles_[best()].T_world_robot, settings_);
  std::vector<std::int32_t> forgotten;
  for (const int slot : contradicted)
    if (!index_.alive(slot)) forgotten.push_back(index_.record(slot).known_id);
  std::vector<int> chosen;
  if (may_create) chosen = choose_new_landmarks(frame, points, seen, index_, settings_);
  const std::vector<LandmarkMatch> created = create_landmarks(frame, points, chosen);
  report(created, AssociationOutcome::created, points, index_, result);
  if (map_smoother_) remember_keyframe(motion, frame, points, created, result);
  loop_open_ = map_smoother_ && settings_.bend_closed_loops && (loop_open_ || result.loop_closed);
  if (loop_open_ && !running_) begin_map_smoothing();
  result.created = static_cast<int>(chosen.size());
  if (smoother_ && remember({frame.utime, motion, measured, points, observed_, created, forgotten,
                             result.T_world_robot, result.covariance}))
    smooth_path_when_due(reunion);

  result.effective_sample_size = effective_sample_size(weights);
  result.resampled = resample_when_due(weights);
  result.best = best_;
  return result;
}

// The motion that the best particle's calibration makes of the odometry's; calibration_ stands in this step.
Motion FastSlam::calibrated_prior(const Motion& motion) {
  Motion prior = motion_prior(motion, settings_);
  calibration_.begin(prior);
  calibration_.prepare_gain(prior.covariance);
  prior.T_from_to = calibration_.apply(particles_[best()].calibration);
  prior.covariance += calibration_.added_covariance();
  return prior;
}

// Every particle draws its new pose, weighs it and updates its landmarks.
std::vector<FastSlam::Verdict> FastSlam::move_particles(const FrameAssociation& association,
                                                        const std::vector<LandmarkMatch>& observed,
                                                        const std::vector<FeaturePoint>& points) {
  std::vector<Verdict> verdicts(particles_.size());
  for_particles(observed.size(), [&](std::size_t begin, std::size_t end) {
    const auto proposal = make_proposal(settings_, association.prior.covariance);
    std::vector<ObservedLandmark> sights;  // the measurements are the same for all, the landmarks are not
    for (const LandmarkMatch& match : observed)
      sights.push_back({points[static_cast<std::size_t>(match.point)].measurement, {}});
    std::vector<const CompactLandmark*> stored;
    for (std::size_t k = begin; k < end; ++k) {
      Particle& particle = particles_[k];
      const Eigen::Isometry3d T_prior =
          association.T_world_found ? *association.T_world_found
          : association.corrected   ? particle.T_world_robot * association.prior.T_from_to
                                    : particle.T_world_robot * calibration_.apply(particle.calibration);
      verdicts[k] = move(particle, T_prior, *proposal, observed, streams_[k], sights, stored);
      if (!association.corrected)
        calibration_.learn(se3_log(T_prior.inverse() * particle.T_world_robot), particle.calibration);
    }
  });
  if (!association.corrected) calibration_.end();
  double highest = particles_[0].log_weight;
  for (const Particle& particle : particles_) highest = std::max(highest, particle.log_weight);
  for (Particle& particle : particles_) particle.log_weight -= highest;
  return verdicts;
}

std::vector<LandmarkMatch> FastSlam::filter(const Motion& motion, const FeatureFrame& frame,
                                            std::vector<FeaturePoint>& points,
                                            std::vector<VisibleLandmark>& expected,
                                            std::vector<int>& contradicted, bool& may_create,
                                            StepResult& result) {
  const bool empty = index_.size() == 0;
  result.motion_usable = usable(motion);
  const Motion prior = calibrated_prior(motion);
  FrameAssociation association = associator_.associate(frame, points, particles_[best()].T_world_robot, prior,
                                                       particles_[best()].map, index_);
  std::vector<LandmarkMatch> observed =
      select_informative(association.matches, frame, points, particles_[best()].map, settings_);
  std::vector<LandmarkMatch> seen = association.matches;
  for (auto* list : {&observed, &seen}) {
    list->insert(list->end(), association.known.begin(), association.known.end());
    sort_by_slot(*list);
  }
  widen_for_correlation(observed, frame.utime, points);

  observed_ = observed;
  const std::vector<Verdict> verdicts = move_particles(association, observed, points);
  std::size_t winner = 0;
  while (particles_[winner].log_weight < 0) ++winner;

  // What the best particle rejects was not seen: it may become a new landmark (thesis 2.3.2).
  const Verdict& verdict = verdicts[winner];
  report_observations(observed, seen, association.rejected, verdict.accepted, points, index_, result);
  bool located = false;  // by a landmark of known identity
  for (std::size_t i = 0; i < observed.size(); ++i) {
    const LandmarkMatch& match = observed[i];
    const bool accepted = verdict.accepted[i];
    result.observations.push_back(
        {points[static_cast<std::size_t>(match.point)].feature, index_.record(match.slot).id, accepted});
    const bool known = index_.record(match.slot).known_id >= 0;
    located = located || (known && accepted);
    if (accepted) continue;
    if (known) contradicted.push_back(match.slot);
    ++result.rejected;
    seen.erase(
        std::find_if(seen.begin(), seen.end(), [&](const LandmarkMatch& m) { return m.slot == match.slot; }));
  }
  result.rejected += static_cast<int>(association.rejected.size());
  result.matched = static_cast<int>(seen.size());
  result.used = verdict.count;
  result.mean_distance2 = verdict.count > 0 ? verdict.distance2 / verdict.count : 0;
  result.slipped = association.slipped;
  result.loop_closed = association.loop_closed;
  const bool agreed =
      located ||
      (settings_.verify_by_consensus ? association.agreed : verdict.count >= settings_.minimum_consensus);
  result.status = association.T_world_found ? TrackStatus::relocalised
                  : agreed                  ? TrackStatus::tracking
                  : empty                   ? TrackStatus::initialising
                  : associator_.steps_without_agreement() > settings_.relocalise_after
                      ? TrackStatus::lost
                      : TrackStatus::predicting;
  // Where known landmarks should be and none is, the robot is elsewhere: do not map that. After a long
  // time without finding back, the world has changed: go on.
  may_create = !association.doubtful;
  if (association.contradicted)
    may_create = associator_.steps_without_agreement() > 10 * settings_.relocalise_after;
  expected = std::move(association.visible);
  if (!agreed) expected.clear();  // nobody is declared missing by a robot that may be elsewhere
  return seen;
}

// Errors with the correlation exp(-|dt| / tau) in time: n of them, dt apart, say as much as
// n (1 - rho) / (1 + rho) independent ones. So the covariance is widened by (1 + rho) / (1 - rho) =
// coth(dt / (2 tau)), dt since the landmark's last measurement; after a long time by nothing.
void FastSlam::widen_for_correlation(const std::vector<LandmarkMatch>& observed, Utime utime,
                                     std::vector<FeaturePoint>& points) {
  if (settings_.correlation_time <= 0) return;
  for (const LandmarkMatch& match : observed) {
    LandmarkRecord& record = index_.record(match.slot);
    const double elapsed = std::max(1e-3, 1e-6 * static_cast<double>(utime - record.measured));
    FeaturePoint& point = points[static_cast<std::size_t>(match.point)];
    widen(1 / std::tanh(0.5 * elapsed / settings_.correlation_time), point.measurement);
    record.measured = utime;
  }
}

std::vector<double> FastSlam::choose_best() {
  std::vector<double> weights = this->weights();
  best_ = static_cast<int>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  return weights;
}

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

FastSlam::Verdict FastSlam::move(Particle& particle, const Eigen::Isometry3d& T_world_prior,
                                 const Proposal& proposal, const std::vector<LandmarkMatch>& observed,
                                 Random& random, std::vector<ObservedLandmark>& sights,
                                 std::vector<const CompactLandmark*>& stored) const {
  // Each particle's landmarks lie somewhere else in memory: all are on their way before the first is used.
  stored.clear();
  for (const LandmarkMatch& match : observed)
    stored.push_back(particle.map.prefetch(static_cast<std::size_t>(match.slot)));
  for (std::size_t i = 0; i < observed.size(); ++i) sights[i].landmark = *stored[i];
  const ProposedPose proposed = proposal.propose(T_world_prior, sights, random);
  particle.T_world_robot = renormalised(proposed.T_world_robot, settings_.planar);
  particle.log_weight += proposed.log_weight;

  const double added = settings_.minimum_landmark_sigma * settings_.minimum_landmark_sigma;
  Verdict verdict;
  verdict.accepted.resize(observed.size());
  for (std::size_t i = 0; i < observed.size(); ++i) {
    const auto& [measurement, landmark] = sights[i];
    const Innovation innovation = innovate(landmark, measurement, particle.T_world_robot);
    const bool accepted = innovation.distance2 <= gate2_;  // exp(-d^2/2) >= gate
    verdict.accepted[i] = accepted;
    if (accepted) {
      particle.log_weight += innovation.log_peak - 0.5 * innovation.distance2;  // log of 2.5, corrected
      particle.map.edit(static_cast<std::size_t>(observed[i].slot)) =
          update_landmark(landmark, innovation, measurement, particle.T_world_robot, added);
      ++verdict.count;
      verdict.distance2 += innovation.distance2;
    } else if (settings_.rejection == RejectionWeight::constant) {
      particle.log_weight += std::log(settings_.p0);
    } else {
      particle.log_weight += innovation.log_peak - 0.5 * gate2_;
    }
  }
  return verdict;
}

std::vector<LandmarkMatch> FastSlam::create_landmarks(const FeatureFrame& frame,
                                                      const std::vector<FeaturePoint>& points,
                                                      const std::vector<int>& chosen) {
  std::vector<std::size_t> slots;
  std::vector<LandmarkMatch> created;
  for (const int p : chosen) {
    const int feature = points[static_cast<std::size_t>(p)].feature;
    const int slot = index_.add(frame.features[static_cast<std::size_t>(feature)], settings_);
    slots.push_back(static_cast<std::size_t>(slot));
    created.push_back({p, slot, 0});
  }
  make_landmarks(created, points);
  const Eigen::Vector3d camera = particles_[best()].T_world_robot * frame.T_robot_camera.translation();
  for (const std::size_t slot : slots) {
    const Eigen::Vector3d ray = camera - particles_[best()].map.find(slot)->mean;
    LandmarkRecord& record = index_.record(static_cast<int>(slot));
    record.measured = frame.utime;
    record.seen_from = ray.normalized();
    record.seen_at = ray.norm();
  }
  return created;
}

void FastSlam::make_landmarks(const std::vector<LandmarkMatch>& created,
                              const std::vector<FeaturePoint>& points) {
  for_particles(created.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      for (const LandmarkMatch& match : created)
        particles_[k].map.edit(static_cast<std::size_t>(match.slot)) = make_landmark(
            points[static_cast<std::size_t>(match.point)].measurement, particles_[k].T_world_robot);
  });
}

void FastSlam::estimate(const std::vector<double>& weights, StepResult& result) const {
  const Eigen::Isometry3d T_best = particles_[best()].T_world_robot;
  const Eigen::Isometry3d T_best_world = T_best.inverse();
  std::vector<Vector6d> offsets(particles_.size());
  result.covariance.setZero();
  Vector6d mean = Vector6d::Zero();
  for (std::size_t k = 0; k < particles_.size(); ++k) {
    offsets[k] = se3_log(T_best_world * particles_[k].T_world_robot);
    mean += weights[k] * offsets[k];
  }
  if (settings_.estimate == PoseEstimate::best) mean.setZero();
  for (std::size_t k = 0; k < particles_.size(); ++k)
    result.covariance += weights[k] * (offsets[k] - mean) * (offsets[k] - mean).transpose();
  const double translation = settings_.shared_translation_sigma, rotation = settings_.shared_rotation_sigma;
  result.covariance.diagonal().head<3>().array() += translation * translation;
  result.covariance.diagonal().tail<3>().array() += rotation * rotation;
  result.covariance =
      (0.5 * (result.covariance + result.covariance.transpose())).eval();  // exactly symmetric
  result.T_world_best = T_best;
  result.T_world_robot = T_best * se3_exp(mean);
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

std::vector<double> FastSlam::weights() const {
  std::vector<double> logs;
  for (const Particle& particle : particles_) logs.push_back(particle.log_weight);
  return normalised_weights(logs);
}

std::vector<Landmark> FastSlam::landmarks() const {
  std::vector<Landmark> result;
  for (int slot = 0; slot < index_.slots(); ++slot)
    if (index_.alive(slot) && index_.record(slot).observations >= settings_.minimum_observations)
      result.push_back(make_public(slot, particles_[best()].map, index_));
  return result;
}

}  // namespace lcmslam
