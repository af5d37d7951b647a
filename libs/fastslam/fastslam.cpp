#include <lcmslam/fastslam/fastslam.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/fastslam/landmarks/existence.hpp>
#include <lcmslam/fastslam/motion_model.hpp>
#include <lcmslam/fastslam/resampling.hpp>

namespace lcmslam {
namespace {

constexpr std::uint64_t resampling_stream = 0x726573616d706c65;
constexpr std::uint64_t smoothing_stream = 0x736d6f6f7468;

FastSlamSettings checked(const FastSlamSettings& settings) {
  check(settings);
  return settings;
}

void sort_by_slot(std::vector<LandmarkMatch>& matches) {
  std::sort(matches.begin(), matches.end(),
            [](const LandmarkMatch& a, const LandmarkMatch& b) { return a.slot < b.slot; });
}

AssociationReport report(const LandmarkMatch& match, AssociationOutcome outcome,
                         const std::vector<FeaturePoint>& points, const LandmarkIndex& index) {
  return {points[static_cast<std::size_t>(match.point)].feature, index.record(match.slot).id, outcome};
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
      resampling_stream_(settings.seed, resampling_stream),
      associator_(settings),
      calibration_(settings),
      smoothing_stream_(settings.seed, smoothing_stream),
      publication_(settings.minimum_observations) {
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    streams_.emplace_back(settings.seed, i);
    particles_[i].lineage = static_cast<int>(i);
  }
  const double translation = settings.shared_translation_sigma, rotation = settings.shared_rotation_sigma;
  unmodelled_.diagonal().head<3>().setConstant(translation * translation);
  unmodelled_.diagonal().tail<3>().setConstant(rotation * rotation);
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
  const Sightings sightings = started_ ? filter(motion, frame, points, result) : Sightings();
  started_ = true;
  // The particle of highest weight is the map; the pose is estimated before resampling adds noise.
  const std::vector<double> weights = choose_best();
  estimate(weights, result);
  shared_error_.observe(sightings.accepted, settings_.minimum_consensus, result.T_world_robot, result.spread);
  tell_covariance(weights, result);
  const bool reunion =
      !sightings.contradicted.empty() ||
      std::any_of(sightings.seen.begin(), sightings.seen.end(), [&](const LandmarkMatch& match) {
        return index_.unseen_steps(match.slot) > settings_.reunion_steps;
      });

  // Landmarks die and are born alike in all particles; new ones last, so that 2.0 is possible.
  result.removed =
      update_existence(index_, particles_[best()].map, frame, points, sightings.expected, sightings.seen,
                       sightings.contradicted, particles_[best()].T_world_robot, settings_);
  std::vector<std::int32_t> forgotten;
  for (const int slot : sightings.contradicted)
    if (!index_.alive(slot)) forgotten.push_back(index_.record(slot).known_id);
  std::vector<int> chosen;
  if (sightings.may_create) chosen = choose_new_landmarks(frame, points, sightings.seen, index_, settings_);
  const std::vector<LandmarkMatch> created = create_landmarks(frame, points, chosen);
  shared_error_.create(created);
  for (const LandmarkMatch& match : created)
    result.associations.push_back(report(match, AssociationOutcome::created, points, index_));
  if (map_smoother_) remember_keyframe(motion, frame, points, created, result);
  loop_open_ = map_smoother_ && settings_.bend_closed_loops && (loop_open_ || result.loop_closed);
  if (loop_open_ && !running_) begin_map_smoothing();
  result.created = static_cast<int>(chosen.size());
  if (smoother_ && remember({frame.utime, motion, measured, points, sightings.observed, created, forgotten,
                             result.T_world_robot, result.spread + unmodelled_}))
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

FastSlam::Sightings FastSlam::filter(const Motion& motion, const FeatureFrame& frame,
                                     std::vector<FeaturePoint>& points, StepResult& result) {
  const bool empty = index_.size() == 0;
  result.motion_usable = usable(motion);
  const Motion prior = calibrated_prior(motion);
  FrameAssociation association = associator_.associate(frame, points, particles_[best()].T_world_robot, prior,
                                                       particles_[best()].map, index_);
  Sightings s;
  s.observed = select_informative(association.matches, frame, points, particles_[best()].map, settings_);
  s.seen = association.matches;
  for (auto* list : {&s.observed, &s.seen}) {
    list->insert(list->end(), association.known.begin(), association.known.end());
    sort_by_slot(*list);
  }
  widen_for_correlation(s.observed, frame.utime, points);

  const std::vector<Verdict> verdicts = move_particles(association, s.observed, points);
  std::size_t winner = 0;
  while (particles_[winner].log_weight < 0) ++winner;
  const Verdict& verdict = verdicts[winner];
  const bool located = judge(verdict, association, points, s, result);

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
  s.may_create = association.contradicted
                     ? associator_.steps_without_agreement() > 10 * settings_.relocalise_after
                     : !association.doubtful;
  if (agreed) s.expected = std::move(association.visible);  // a robot that may be elsewhere misses nobody
  return s;
}

// What the best particle rejects was not seen: it may become a new landmark (thesis 2.3.2). Returns whether
// it believes a landmark of known identity. `seen` and `observed` are ordered by slot; `seen` holds all of
// `observed`.
bool FastSlam::judge(const Verdict& verdict, const FrameAssociation& association,
                     const std::vector<FeaturePoint>& points, Sightings& sightings,
                     StepResult& result) const {
  bool located = false;
  std::vector<LandmarkMatch> believed;
  std::size_t next = 0;
  for (const LandmarkMatch& match : sightings.seen) {
    const bool used = next < sightings.observed.size() && sightings.observed[next].slot == match.slot;
    const bool accepted = used && verdict.accepted[next++] != 0;
    const AssociationReport told = report(match,
                                          accepted ? AssociationOutcome::accepted
                                          : used   ? AssociationOutcome::rejected
                                                   : AssociationOutcome::unused,
                                          points, index_);
    result.associations.push_back(told);
    if (used) result.observations.push_back({told.feature, told.landmark, accepted});
    const bool known = index_.record(match.slot).known_id >= 0;
    located = located || (known && accepted);
    if (accepted) sightings.accepted.push_back(match);
    if (!used || accepted)
      believed.push_back(match);
    else if (known)
      sightings.contradicted.push_back(match.slot);
  }
  for (const LandmarkMatch& match : association.rejected)
    result.associations.push_back(report(match, AssociationOutcome::rejected, points, index_));
  result.rejected = static_cast<int>(sightings.seen.size() - believed.size() + association.rejected.size());
  sightings.seen = std::move(believed);
  result.matched = static_cast<int>(sightings.seen.size());
  result.used = verdict.count;
  result.mean_distance2 = verdict.count > 0 ? verdict.distance2 / verdict.count : 0;
  result.slipped = association.slipped;
  result.loop_closed = association.loop_closed;
  return located;
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

std::vector<Landmark> FastSlam::landmarks() const {
  std::vector<Landmark> result;
  for (int slot = 0; slot < index_.slots(); ++slot)
    if (index_.alive(slot) && index_.record(slot).observations >= settings_.minimum_observations)
      result.push_back(make_public(slot, particles_[best()].map, index_));
  return result;
}

}  // namespace lcmslam
