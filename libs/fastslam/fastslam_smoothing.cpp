// FastSlam: what it remembers for the smoothers, and what it takes over from them.

#include <algorithm>
#include <set>

#include <lcmslam/fastslam/fastslam.hpp>
#include <lcmslam/fastslam/motion_model.hpp>
#include <lcmslam/fastslam/pose_space.hpp>

namespace lcmslam {
namespace {

constexpr Utime smoothing_time = 2'000'000;  // us that the map smoother has beside the filter
constexpr Utime time_per_pose = 100;         // us that the path smoother has, for each pose; takes about 70
constexpr double urgent_factor = 2;          // times its share of a core: where few lineages are left

}  // namespace

// A step for the path smoother; kept for later while the solver runs. False, and no smoother any more, when
// landmarks are not of known identity and planar.
bool FastSlam::remember(PathStep step) {
  for (const FeaturePoint& point : step.used)
    if (point.landmark_id < 0 || point.measurement.kind == MeasurementKind::point) {
      running_path_.reset();  // waits
      since_.clear();
      smoother_.reset();
      drawn_anew_ = false;  // where the paths began will be forgotten
      return false;
    }
  if (running_path_)
    since_.push_back(std::move(step));
  else
    add_to_path(step, motion_prior(step.motion, settings_));
  return true;
}

// All sights of known identity, believed by the filter or not. The values are as measured, the covariances
// those that the filter used. calibration_ stands in this step.
void FastSlam::add_to_path(const PathStep& step, const Motion& prior) {
  // First, since what has died may have been born again in the same step.
  for (const std::int32_t id : step.forgotten) smoother_->forget(id);
  std::vector<IdentifiedMeasurement> sights;
  for (std::size_t i = 0; i < step.used.size(); ++i) {
    sights.push_back({step.used[i].landmark_id, step.measured[i].measurement});
    sights.back().measurement.covariance = step.used[i].measurement.covariance;
  }
  smoother_->add(step.utime, prior, calibration_.jacobian(), sights, step.T_world_robot, step.covariance);
}

// What the best particle accepted, and what it saw for the first time.
void FastSlam::remember_keyframe(const Motion& motion, const FeatureFrame& frame,
                                 const std::vector<FeaturePoint>& points,
                                 const std::vector<LandmarkMatch>& created, const StepResult& result) {
  std::vector<std::int64_t> landmark_of(frame.features.size(), -1);
  for (const ObservationReport& seen : result.observations)
    if (seen.accepted) landmark_of[static_cast<std::size_t>(seen.feature)] = seen.landmark;
  for (const LandmarkMatch& match : created)
    landmark_of[static_cast<std::size_t>(points[static_cast<std::size_t>(match.point)].feature)] =
        index_.record(match.slot).id;
  std::vector<PointSight> sights;
  for (const FeaturePoint& point : points) {
    if (point.is_bearing()) continue;
    if (point.measurement.kind != MeasurementKind::point) {
      map_smoother_.reset();
      return;
    }
    const std::int64_t landmark = landmark_of[static_cast<std::size_t>(point.feature)];
    if (landmark >= 0) sights.push_back({landmark, point.measurement});
  }
  // At a closed loop the odometry ties what was mapped astray to what is there: the loop bends it all.
  std::optional<Motion> believed;
  if ((result.status != TrackStatus::relocalised || result.loop_closed) && !result.slipped)
    believed = motion_prior(motion, settings_);
  map_smoother_->add(frame.utime, particles_[best()].T_world_robot, believed, sights, result.loop_closed);
}

// Landmarks that the smoother does not know, but that were seen of late, move as the robot does.
std::vector<SmoothedPose> FastSlam::take_over(const std::optional<MapSmoothing>& smoothing) {
  if (!smoothing) return {};
  for (int slot = 0; slot < index_.slots(); ++slot) {
    if (!index_.alive(slot)) continue;
    const auto found = smoothing->landmarks.find(index_.record(slot).id);
    const bool known = found != smoothing->landmarks.end();
    if (!known && index_.unseen_steps(slot) > settings_.tentative_steps) continue;
    for (Particle& particle : particles_) {
      CompactLandmark& landmark = particle.map.edit(static_cast<std::size_t>(slot));
      landmark.mean = known ? found->second : smoothing->T_world_correction * landmark.mean;
    }
  }
  for (Particle& particle : particles_)
    particle.T_world_robot =
        renormalised(smoothing->T_world_correction * particle.T_world_robot, settings_.planar);
  return smoothing->path;
}

bool FastSlam::begin_smoothing() {
  if (smoothing()) return false;
  if (smoother_ && smoother_->size() >= 2) {
    if (!running_path_) begin_path_smoothing();
    running_path_->wanted = true;
    return true;
  }
  if (!map_smoother_ || map_smoother_->keyframes() < 2) return false;
  if (!running_) begin_map_smoothing();
  running_->wanted = true;
  return true;
}

void FastSlam::begin_map_smoothing() {
  running_ =
      RunningSmoothing{std::async(std::launch::async, [copy = *map_smoother_] { return copy.solve(); }),
                       last_utime_ + smoothing_time};
  loop_open_ = false;
}

std::vector<SmoothedPose> FastSlam::smooth() {
  if (map_smoother_) {
    running_.reset();  // what it would tell is told now
    return take_over(map_smoother_->solve());
  }
  if (!smoother_) return {};
  if (running_path_) take_over_path();
  begin_path_smoothing();
  if (!take_over_path()) return {};
  taken_over_.clear();  // older
  best_ = 0;            // the posterior's mode
  return smoother_->path();
}

// The path is smoothed when a landmark came back after long, a sight contradicts its landmark or few lineages
// are left: within seconds the last ones may lead far astray (Victoria Park: two lineages, a spread of 0.2 m,
// an error of 10 m). It waits until the solver has rested: where sights are rare and come together, it has,
// and is there at once.
void FastSlam::smooth_path_when_due(bool reunion) {
  reunited_ = reunited_ || reunion;
  const bool few = coalesced();
  if (running_path_ || smoother_->size() < 2 || (!reunited_ && !few)) return;
  const double share = (few ? urgent_factor : 1) * settings_.rejuvenation_share;
  if (share * static_cast<double>(last_utime_ - smoothed_at_) >= static_cast<double>(solving_time()))
    begin_path_smoothing();
}

Utime FastSlam::solving_time() const {
  return time_per_pose * static_cast<Utime>(smoother_->size());
}

// The solver's time is bounded by the path's length and not by the clock: a replay is the same.
void FastSlam::begin_path_smoothing() {
  const auto draw = [smoother = smoother_.get(), count = particles_.size(), stream = smoothing_stream_] {
    PathDraw result;
    result.cost = smoother->solve();
    result.stream = stream;
    result.samples = smoother->sample(count, result.stream, result.calibration_covariance);
    return result;
  };
  running_path_ = RunningPath{std::async(std::launch::async, draw), last_utime_ + solving_time()};
  smoothed_at_ = last_utime_;
  reunited_ = false;
}

// The particles as drawn from the posterior of the path as it was, and then the way that was gone since.
bool FastSlam::take_over_path() {
  const bool wanted = running_path_->wanted;
  auto result = std::move(running_path_->result);
  running_path_.reset();
  const PathDraw draw = result.get();
  smoothing_stream_ = draw.stream;
  smoothing_cost_ = draw.cost;
  if (wanted) taken_over_ = smoother_->path();
  const std::vector<PathStep> since = std::exchange(since_, {});
  std::set<int> unborn;  // slots of landmarks that were not there yet
  for (const PathStep& step : since)
    for (const LandmarkMatch& match : step.created) unborn.insert(match.slot);
  const bool drawn = !draw.samples.empty();
  if (drawn) draw_anew(draw, unborn);
  for (const PathStep& step : since) {
    const Motion prior = motion_prior(step.motion, settings_);
    calibration_.begin(prior);
    add_to_path(step, prior);
    if (drawn) repeat(step, unborn);
  }
  choose_best();
  return drawn;
}

void FastSlam::draw_anew(const PathDraw& draw, const std::set<int>& unborn) {
  calibration_.set_covariance(draw.calibration_covariance);
  sensor_ = smoother_->sensor();
  for (std::size_t k = 0; k < particles_.size(); ++k) {
    Particle& particle = particles_[k];
    particle.T_world_robot = draw.samples[k].T_world_robot;
    particle.T_world_start = draw.samples[k].T_world_start;
    particle.calibration = draw.samples[k].calibration;
    particle.log_weight = 0;
    particle.lineage = static_cast<int>(k);
    for (const auto& [id, landmark] : draw.samples[k].landmarks)
      if (const int slot = index_.find(id); slot >= 0 && unborn.count(slot) == 0)
        particle.map.edit(static_cast<std::size_t>(slot)) = landmark;
  }
  drawn_anew_ = true;
  best_ = 0;  // the mode
}

// The particles go through a step once more. Who is who and what exists stays decided.
void FastSlam::repeat(const PathStep& step, std::set<int>& unborn) {
  FrameAssociation same;
  same.prior = calibrated_prior(step.motion);
  std::vector<FeaturePoint> points = step.used;
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i].measurement.value = sensor_.corrected(step.measured[i].measurement).value;
  std::vector<LandmarkMatch> observed;
  for (const LandmarkMatch& match : step.observed)
    if (index_.alive(match.slot) && unborn.count(match.slot) == 0) observed.push_back(match);
  move_particles(same, observed, points);
  make_landmarks(step.created, points);
  for (const LandmarkMatch& match : step.created) unborn.erase(match.slot);
  resample_when_due(choose_best());
}

// Resampling has made few ancestors' paths the past of all particles: their spread no longer tells what is
// not known of it, and their mean wanders off (genetic drift).
bool FastSlam::coalesced() const {
  std::vector<char> lives(particles_.size(), 0);
  for (const Particle& particle : particles_) lives[static_cast<std::size_t>(particle.lineage)] = 1;
  const auto lineages = static_cast<double>(std::count(lives.begin(), lives.end(), 1));
  return lineages < settings_.rejuvenation_lineages * settings_.particles;
}

}  // namespace lcmslam
