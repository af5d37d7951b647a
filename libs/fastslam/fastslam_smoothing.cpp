// FastSlam: what it gives to the smoothers, and what it takes over from them.

#include <algorithm>
#include <map>

#include <lcmslam/fastslam/fastslam.hpp>

namespace lcmslam {

// Each smoother ends where it sees the other's landmarks.
void FastSlam::smooth_beside(StepRecord step, bool reunion, const StepResult& result) {
  if (map_smoothing_) {
    // As the best particle believes it: what is systematic would bend the map.
    const OdometryCalibration& calibration = particles_.calibration();
    const Motion calibrated{calibration.apply(particles_.best().calibration),
                            step.odometry.covariance + calibration.added_covariance()};
    map_smoothing_->add(step.utime, calibrated, step.used, result);
  }
  if (path_smoothing_ && !BackgroundPathSmoothing::fits(step.used)) {
    path_smoothing_.reset();  // waits
    particles_.forget_start();
  }
  if (!path_smoothing_) return;
  path_smoothing_->add(std::move(step));
  path_smoothing_->begin_when_due(reunion, particles_.coalesced());
}

bool FastSlam::begin_smoothing() {
  if (smoothing()) return false;
  return (path_smoothing_ && path_smoothing_->begin_on_request()) ||
         (map_smoothing_ && map_smoothing_->begin_on_request());
}

bool FastSlam::smoothing() const {
  return (map_smoothing_ && map_smoothing_->requested()) || (path_smoothing_ && path_smoothing_->requested());
}

std::vector<SmoothedPose> FastSlam::smooth() {
  if (map_smoothing_ && map_smoothing_->active()) return take_over(map_smoothing_->smooth());
  if (!path_smoothing_) return {};
  if (path_smoothing_->running()) take_over(path_smoothing_->take_over());
  const SmoothedPath smoothed = path_smoothing_->smooth();
  if (!take_over(smoothed)) return {};
  taken_over_.clear();  // older
  return smoothed.path;
}

// Returns whether the particles were drawn anew.
bool FastSlam::take_over_when_due(Utime now) {
  if (map_smoothing_)
    if (const auto done = map_smoothing_->take_over_when_due(now)) {
      auto path = take_over(done->smoothing);
      if (done->requested) taken_over_ = std::move(path);
    }
  return path_smoothing_ && path_smoothing_->due(now) && take_over(path_smoothing_->take_over());
}

// Landmarks that the smoother does not know, but that were seen of late, move as the robot does.
std::vector<SmoothedPose> FastSlam::take_over(const std::optional<MapSmoothing>& smoothing) {
  if (!smoothing) return {};
  std::map<int, Eigen::Vector3d> placed;
  std::vector<int> carried;
  for (int slot = 0; slot < index_.slots(); ++slot) {
    if (!index_.alive(slot)) continue;
    const auto found = smoothing->landmarks.find(index_.record(slot).id);
    if (found != smoothing->landmarks.end())
      placed[slot] = found->second;
    else if (index_.unseen_steps(slot) <= settings_.tentative_steps)
      carried.push_back(slot);
  }
  particles_.deform(smoothing->T_world_correction, placed, carried);
  map_smoothing_->taken_over(*smoothing);
  return smoothing->path;
}

// The particles as drawn from the posterior of the path as it was, and then the way that was gone since.
bool FastSlam::take_over(const SmoothedPath& smoothed) {
  smoothing_cost_ = smoothed.cost;
  if (smoothed.requested) taken_over_ = smoothed.path;
  const bool drawn = !smoothed.samples.empty();
  if (drawn) {
    std::set<int> unborn;  // slots of landmarks that were not there yet
    for (const StepRecord& step : smoothed.since)
      for (const LandmarkMatch& match : step.created) unborn.insert(match.slot);
    sensor_ = smoothed.sensor;
    particles_.draw_anew(smoothed.samples, smoothed.calibration_covariance, [&](std::int32_t identity) {
      const int slot = index_.find(identity);
      return unborn.count(slot) == 0 ? slot : -1;
    });
    for (const StepRecord& step : smoothed.since) repeat(step, unborn);
  }
  particles_.choose_best();
  return drawn;
}

// The particles go through a step once more. Which feature shows which landmark and what exists stays
// decided.
void FastSlam::repeat(const StepRecord& step, std::set<int>& unborn) {
  const StepPrior prior{particles_.predict(step.odometry).covariance, std::nullopt, std::nullopt,
                        std::nullopt};
  std::vector<FeaturePoint> points = step.used;
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i].measurement.value = sensor_.corrected(step.measured[i].measurement).value;
  std::vector<LandmarkMatch> observed;
  for (const LandmarkMatch& match : step.observed)
    if (index_.alive(match.slot) && unborn.count(match.slot) == 0) observed.push_back(match);
  if (step.blind) return particles_.go_blindly(prior);
  particles_.propose_weigh_update(prior, observed, points);
  particles_.make_landmarks(step.created, points);
  for (const LandmarkMatch& match : step.created) unborn.erase(match.slot);
  particles_.resample_when_due(particles_.choose_best());
}

}  // namespace lcmslam
