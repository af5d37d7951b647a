// FastSlam: what it remembers for the smoothers, and what it takes over from them.

#include <algorithm>

#include "fastslam/fastslam.hpp"
#include "fastslam/motion_model.hpp"
#include "fastslam/pose_space.hpp"

namespace lcmslam {
namespace {

constexpr Utime kSmoothingTime = 2'000'000;  // us that the map smoother has beside the filter

}  // namespace

// The step for the smoother: all sights of known identity, believed by the filter or not.
// The values are as measured, the covariances those that the filter used.
void FastSlam::remember(Utime utime, const Motion& motion, const std::vector<FeaturePoint>& measured,
                        const std::vector<FeaturePoint>& points, const StepResult& result) {
  std::vector<IdentifiedMeasurement> sights;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Measurement measurement = points[i].measurement;
    if (points[i].landmark_id < 0 || measurement.kind == MeasurementKind::point) {
      smoother_.reset();
      return;
    }
    measurement.value = measured[i].measurement.value;
    sights.push_back({points[i].landmark_id, measurement});
  }
  smoother_->add(utime, motion_prior(motion, settings_), calibration_.jacobian(), sights,
                 result.T_world_robot, result.covariance);
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
  std::optional<Motion> believed;
  if (result.status != TrackStatus::relocalised && !result.slipped)
    believed = motion_prior(motion, settings_);
  map_smoother_->add(frame.utime, particles_[best()].T_world_robot, believed, sights);
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
  if (!map_smoother_ || running_ || map_smoother_->keyframes() < 2) return false;
  running_ =
      RunningSmoothing{std::async(std::launch::async, [copy = *map_smoother_] { return copy.solve(); }),
                       last_utime_ + kSmoothingTime};
  return true;
}

std::vector<SmoothedPose> FastSlam::smooth() {
  if (map_smoother_) {
    running_.reset();  // what it would tell is told now
    return take_over(map_smoother_->solve());
  }
  if (!smoother_ || !rejuvenate()) return {};
  best_ = 0;  // the posterior's mode
  return smoother_->path();
}

// Draws all particles anew from the posterior of the whole path.
bool FastSlam::rejuvenate() {
  smoothing_cost_ = smoother_->solve();
  Eigen::Matrix3d calibration_covariance;
  const auto samples = smoother_->sample(particles_.size(), smoothing_stream_, calibration_covariance);
  const double grown = (1 + settings_.rejuvenation_growth) * static_cast<double>(smoother_->size());
  smooth_at_ = std::max(smoother_->size() + 10, static_cast<std::size_t>(grown));
  if (samples.empty()) return false;
  calibration_.set_covariance(calibration_covariance);
  sensor_ = smoother_->sensor();
  for (std::size_t k = 0; k < particles_.size(); ++k) {
    Particle& particle = particles_[k];
    particle.T_world_robot = samples[k].T_world_robot;
    particle.calibration = samples[k].calibration;
    particle.log_weight = 0;
    particle.lineage = static_cast<int>(k);
    for (const auto& [id, landmark] : samples[k].landmarks)
      if (const int slot = index_.find(id); slot >= 0)
        particle.map.edit(static_cast<std::size_t>(slot)) = landmark;
  }
  return true;
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
