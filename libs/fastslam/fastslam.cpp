#include <lcmslam/fastslam/fastslam.hpp>

#include <algorithm>

#include <lcmslam/fastslam/landmarks/existence.hpp>
#include <lcmslam/fastslam/resampling.hpp>

namespace lcmslam {
namespace {

constexpr Utime longest_unseen = 800'000;  // us without agreement: lost within a second, at a few frames each

FastSlamSettings checked(const FastSlamSettings& settings) {
  check(settings);
  return settings;
}

std::vector<FeaturePoint> corrected(std::vector<FeaturePoint> points, const SensorCalibration& sensor) {
  for (FeaturePoint& point : points) point.measurement = sensor.corrected(point.measurement);
  return points;
}

StepPrior step_prior(const FrameAssociation& association, const std::optional<GroundPull>& ground) {
  StepPrior prior{association.prior.covariance, std::nullopt, association.T_world_found, ground};
  if (association.corrected) prior.T_from_to = association.prior.T_from_to;
  return prior;
}

}  // namespace

FastSlam::FastSlam(const FastSlamSettings& settings)
    : settings_(checked(settings)),
      ground_(settings.ground),
      unknown_(settings),
      particles_(settings),
      associator_(settings),
      covariance_(settings),
      publication_(settings.minimum_observations) {
  if (settings.smooth_map) map_smoothing_ = std::make_unique<BackgroundMapSmoothing>(settings);
  if (settings.rejuvenate && settings.planar)
    path_smoothing_ = std::make_unique<BackgroundPathSmoothing>(settings);
}

StepResult FastSlam::step(const Motion& motion, const FeatureFrame& frame) {
  // What was smoothed beside the filter comes first; then the frame, as measurements.
  StepResult result;
  result.rejuvenated = take_over_when_due(frame.utime);
  std::vector<FeaturePoint> measured = usable_features(frame, settings_);
  if (started_ && usable(motion))
    widen_for_motion(se3_log(motion.T_from_to) / elapsed(frame.utime), settings_.timing_sigma, measured);
  std::vector<FeaturePoint> points = corrected(measured, sensor_);
  result.offered = static_cast<int>(
      std::count_if(points.begin(), points.end(), [](const FeaturePoint& p) { return !p.is_bearing(); }));
  Motion odometry = with_ground(unknown_.prior(motion, frame.utime), settings_);
  StepObservations observations;
  Motion own_motion;                            // of this step, with what was unknown before it
  Matrix6d step_covariance = Matrix6d::Zero();  // and without
  Vector6d twist = Vector6d::Zero();            // m/s, rad/s
  std::optional<Matrix6d> prior_covariance;     // of the pose before it looked
  bool mapping = true, blind = false;

  if (!std::exchange(started_, true)) {
    agreed_utime_ = frame.utime;
  } else {
    // Associate: which feature shows which landmark, as the best particle sees it.
    result.motion_usable = usable(motion);
    follow_wheels(motion);
    Predicted predicted = predict(odometry);
    const auto associate = [&] {
      return associator_.associate(frame, points, particles_.best().T_world_robot, predicted.motion,
                                   particles_.best().map, index_, unknown_.whereabouts());
    };
    FrameAssociation association = associate();
    if (const auto seen = refuses_ground(association)) {
      if (leave_for(*seen)) odometry = with_ground(odometry, settings_);
      predicted = predict(odometry);
      association = associate();
    }
    if (association.free) ground_.observe(association.free->T_world_robot, association.free->covariance);
    result.floor = ground_.floor();
    own_motion = {predicted.motion.T_from_to,
                  odometry.covariance + particles_.calibration().added_covariance()};
    step_covariance =
        with_ground(unknown_.step(), settings_).covariance + particles_.calibration().added_covariance();
    if (nothing_to_find_back(association, points)) return begin_anew(motion, frame);
    observations = select_observations(association, frame, points, particles_.best().map, settings_);
    widen_for_correlation(observations.observed, frame.utime, settings_.correlation_time, index_, points);

    // Propose, weigh, update: each particle draws its pose, is weighed by what it observes from there, and
    // its landmarks learn from it (particle_update.cpp). Where it observes nothing and may map nothing, no
    // particle is better than another.
    look_whether_carried(association, points, frame.utime);
    mapping = may_map(association);
    blind = observations.seen.empty() && (points.empty() || !mapping);
    Verdict verdict;
    if (blind)
      particles_.go_blindly(step_prior(association, predicted.ground));
    else
      verdict = particles_.propose_weigh_update(step_prior(association, predicted.ground),
                                                observations.observed, points);
    // Errors go the same way as the particles.
    if (association.corrected) own_motion.T_from_to = association.prior.T_from_to;
    covariance_.move(own_motion);
    twist = se3_log(own_motion.T_from_to) / elapsed(frame.utime);
    // Also where the landmarks put the motion right: the few that are believed then may not tell all of it.
    if (association.T_world_found) covariance_.find(association.prior.covariance);
    prior_covariance = association.prior.covariance;
    const bool located = judge(verdict, association, points, index_, observations, result);
    const bool agreed = agree(association, verdict, located);
    if (agreed) unknown_.end();
    if (agreed || association.confirmed) note_agreement(frame.utime);
    if (agreed) unplaced_ = adrift_ = 0;
    result.unplaced = unplaced_;
    result.adrift = adrift_;
    result.status = status(association, agreed, frame.utime);
    if (result.status == TrackStatus::tracking || result.status == TrackStatus::relocalised)
      observations.expected = std::move(association.visible);  // a robot that may be elsewhere misses nobody
  }

  // Estimate, before resampling adds noise. The particle of highest weight is the map.
  const std::vector<double> weights = particles_.choose_best();
  const ParticleSet::Estimate estimate = particles_.estimate(weights);
  result.T_world_best = particles_.best().T_world_robot;
  covariance_.observe(observations.accepted,
                      {frame, points, particles_.best().map, index_, result.T_world_best, twist},
                      prior_covariance);
  publish_estimate(estimate, weights, {own_motion.T_from_to, step_covariance}, frame.T_robot_camera, result);

  // Deaths and births, alike in all particles. New landmarks last, so that 2.0 is possible: nobody was
  // weighed by a landmark that his own step had made.
  const bool reunited = reunion(observations);
  std::vector<std::int32_t> dead;
  if (!blind) dead = remove_landmarks(frame, points, observations, result);
  std::vector<LandmarkMatch> created;
  if (mapping && !blind) created = create_landmarks(frame, points, observations, result);
  covariance_.create(created, {frame, points, particles_.best().map, index_, result.T_world_best, twist});
  utime_ = frame.utime;

  // Remember the step for smoothing, which may begin.
  smooth_beside(
      {frame.utime, odometry, particles_.calibration().jacobian(), std::move(measured), std::move(points),
       observations.observed, created, blind, dead, estimate.T_world_robot, covariance_.in_map(estimate)},
      reunited, result);

  // Resample.
  result.effective_sample_size = effective_sample_size(weights);
  result.resampled = particles_.resample_when_due(weights);
  result.best = particles_.best_index();
  return result;
}

// Since the last step, s.
double FastSlam::elapsed(Utime utime) const {
  return 1e-6 * static_cast<double>(std::max<Utime>(utime - utime_, 1000));
}

// Once a robot has left the plane its motion has six degrees of freedom, and where it stands on the plane
// again that says what it says.
FastSlam::Predicted FastSlam::predict(const Motion& odometry) {
  Predicted predicted{particles_.predict(odometry), std::nullopt};
  if (!settings_.left_plane || ground_.floor() == Floor::free) return predicted;
  Motion& motion = predicted.motion;
  const Eigen::Isometry3d& T_world_robot = particles_.best().T_world_robot;
  predicted.ground.emplace(ground_, motion.covariance);
  motion.T_from_to = T_world_robot.inverse() * (*predicted.ground)(T_world_robot * motion.T_from_to);
  motion.covariance = predicted.ground->reduced(motion.covariance);
  return predicted;
}

// The floor had no part in the pose on which most matches agree in space.
std::optional<Floor> FastSlam::refuses_ground(const FrameAssociation& association) const {
  if (!(settings_.planar || settings_.left_plane) || !association.free) return std::nullopt;
  const Floor seen = ground_.seen(association.free->T_world_robot, association.free->covariance);
  return seen > ground_.floor() ? std::make_optional(seen) : std::nullopt;
}

// Returns whether it was the first time.
bool FastSlam::leave_for(Floor floor) {
  ground_.leave_for(floor);
  if (settings_.left_plane) return false;
  settings_.planar = false;
  settings_.left_plane = true;
  unknown_.leave_plane(settings_);
  particles_.leave_plane(settings_);
  associator_.leave_plane(settings_);
  covariance_.leave_plane();
  if (map_smoothing_) map_smoothing_->leave_plane(settings_);
  return true;
}

void FastSlam::publish_estimate(const ParticleSet::Estimate& estimate, const std::vector<double>& weights,
                                const Motion& motion, const Eigen::Isometry3d& T_robot_camera,
                                StepResult& result) {
  result.T_world_robot = estimate.T_world_robot;
  result.spread = estimate.spread;
  result.covariance = covariance_.from_start(particles_, weights, estimate, T_robot_camera);
  local_frame_.advance(result.T_world_robot, motion);
  result.T_local_robot = local_frame_.T_local_robot();
  result.T_world_local = local_frame_.T_map_local();
  result.local_covariance = covariance_.in_map(estimate);
  const Matrix6d A = adjoint(result.T_local_robot);
  result.correction_covariance = A * result.covariance * A.transpose();
}

// A lost robot before it has mapped anything that anybody was told of.
bool FastSlam::nothing_to_find_back(const FrameAssociation& association,
                                    const std::vector<FeaturePoint>& points) const {
  if (!unknown_.lost() || association.agreed || !association.known.empty()) return false;
  if (static_cast<int>(points.size()) < settings_.minimum_consensus) return false;
  for (int slot = 0; slot < index_.slots(); ++slot)
    if (index_.alive(slot) && index_.record(slot).observations >= settings_.minimum_observations)
      return false;
  return true;
}

// The world may as well begin here.
StepResult FastSlam::begin_anew(const Motion& motion, const FeatureFrame& frame) {
  const LocalFrame local_frame = local_frame_;
  FastSlamSettings settings = settings_;
  settings.planar = settings.planar || settings.left_plane;
  settings.left_plane = false;
  *this = FastSlam(settings);
  local_frame_ = local_frame;
  return step(motion, frame);
}

// Whether this step's measurements tell where the robot is in its map.
bool FastSlam::agree(const FrameAssociation& association, const Verdict& verdict, bool located) const {
  return located ||
         (settings_.verify_by_consensus ? association.agreed : verdict.count >= settings_.minimum_consensus);
}

// A good odometry may know the way for long: whoever reads the status learns that the map says nothing.
TrackStatus FastSlam::status(const FrameAssociation& association, bool agreed, Utime utime) const {
  if (association.T_world_found) return TrackStatus::relocalised;
  if (agreed) return TrackStatus::tracking;
  if (index_.size() == 0) return TrackStatus::initialising;
  const bool contradicted = associator_.steps_without_agreement() > settings_.relocalise_after;
  const bool unseen = utime - agreed_utime_ > longest_unseen;
  const bool lost = unknown_.lost() || contradicted || unseen;
  return lost ? TrackStatus::lost : TrackStatus::predicting;
}

void FastSlam::follow_wheels(const Motion& motion) {
  constexpr double about_there = 0.3;  // m, rad
  stands_ = stands_ && usable(motion) && !motion.visual;
  if (stands_) T_agreed_robot_ = T_agreed_robot_ * motion.T_from_to;
  stands_ = stands_ && T_agreed_robot_.translation().norm() < about_there &&
            rotation_angle(T_agreed_robot_) < about_there;
}

void FastSlam::note_agreement(Utime utime) {
  agreed_utime_ = utime;
  T_agreed_robot_.setIdentity();
  stands_ = true;
}

// Where known landmarks should be and none is, the robot is elsewhere, whatever odometry knows: somebody has
// carried it, and odometry's way has begun at a wrong place until something is recognised. Who may be
// anywhere expects no landmark: that it knows nothing of all it sees tells the same, less surely.
void FastSlam::look_whether_carried(const FrameAssociation& association,
                                    const std::vector<FeaturePoint>& points, Utime utime) {
  constexpr double longest_frame = 1;  // s that one frame speaks for
  if (association.agreed || association.confirmed) unplaced_ = 0;
  // Before a robot whose wheels stand somebody else may have stepped; who drives on would have hit him.
  hidden_ = association.hidden && stands_;
  if (hidden_) return;
  const bool enough = static_cast<int>(points.size()) >= settings_.minimum_consensus;
  const double seconds = std::min(1e-6 * static_cast<double>(utime - utime_), longest_frame);
  if (association.contradicted || (unplaced_ > 0 && !association.agreed && enough)) unplaced_ += seconds;
  if (unknown_.lost() && enough) adrift_ += seconds;
}

// A robot that may be anywhere in its map would map what it knows at a wrong place.
bool FastSlam::may_map(const FrameAssociation& association) const {
  if (unknown_.lost() && !association.agreed && association.known.empty()) return false;
  return unplaced_ == 0 && !hidden_ && !association.doubtful;
}

// A landmark came back after long, or is not where it was.
bool FastSlam::reunion(const StepObservations& observations) const {
  return !observations.contradicted.empty() ||
         std::any_of(observations.seen.begin(), observations.seen.end(), [&](const LandmarkMatch& match) {
           return index_.unseen_steps(match.slot) > settings_.reunion_steps;
         });
}

// Returns the identities whose landmark died of contradiction.
std::vector<std::int32_t> FastSlam::remove_landmarks(const FeatureFrame& frame,
                                                     const std::vector<FeaturePoint>& points,
                                                     const StepObservations& observations,
                                                     StepResult& result) {
  const Particle& best = particles_.best();
  result.removed = update_existence(index_, best.map, frame, points, observations.expected, observations.seen,
                                    observations.contradicted, best.T_world_robot, settings_);
  std::vector<std::int32_t> dead;
  for (const int slot : observations.contradicted)
    if (!index_.alive(slot)) dead.push_back(index_.record(slot).known_id);
  return dead;
}

std::vector<LandmarkMatch> FastSlam::create_landmarks(const FeatureFrame& frame,
                                                      const std::vector<FeaturePoint>& points,
                                                      const StepObservations& observations,
                                                      StepResult& result) {
  std::vector<LandmarkMatch> created;
  for (const int p : choose_new_landmarks(frame, points, observations.expected, observations.seen, index_,
                                          particles_.best().T_world_robot, settings_)) {
    const int feature = points[static_cast<std::size_t>(p)].feature;
    const int slot = index_.add(frame.features[static_cast<std::size_t>(feature)], settings_);
    created.push_back({p, slot, 0});
    result.associations.push_back(report(created.back(), AssociationOutcome::created, points, index_));
  }
  result.created = static_cast<int>(created.size());
  particles_.make_landmarks(created, points);
  const Particle& best = particles_.best();
  const Eigen::Vector3d camera = best.T_world_robot * frame.T_robot_camera.translation();
  for (const LandmarkMatch& match : created) {
    const Eigen::Vector3d ray = camera - best.map.find(static_cast<std::size_t>(match.slot))->mean;
    LandmarkRecord& record = index_.record(match.slot);
    record.measured = frame.utime;
    record.seen_from = ray.normalized();
    record.seen_at = ray.norm();
    record.born = frame.utime;
  }
  return created;
}

std::vector<Landmark> FastSlam::landmarks() const {
  std::vector<Landmark> result;
  for (int slot = 0; slot < index_.slots(); ++slot)
    if (index_.alive(slot) && index_.record(slot).observations >= settings_.minimum_observations)
      result.push_back(published(slot));
  return result;
}

Landmark FastSlam::published(int slot) const {
  Landmark landmark = make_public(slot, particles_.best().map, index_);
  landmark.covariance = covariance_.of_landmark(slot, particles_);
  return landmark;
}

MapChanges FastSlam::take_changes() {
  return publication_.take(particles_.best().map, index_, [this](int slot) { return published(slot); });
}

}  // namespace lcmslam
