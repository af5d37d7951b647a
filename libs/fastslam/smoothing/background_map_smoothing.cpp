#include <lcmslam/fastslam/smoothing/background_map_smoothing.hpp>

#include <map>
#include <utility>

namespace lcmslam {
namespace {

constexpr Utime smoothing_time = 2'000'000;  // us that the smoother has beside the filter

// The landmark of each feature that the best particle accepted or that was seen for the first time.
std::map<int, std::int64_t> believed_landmarks(const StepResult& result) {
  std::map<int, std::int64_t> landmark_of;
  for (const AssociationReport& seen : result.associations)
    if (seen.outcome == AssociationOutcome::accepted || seen.outcome == AssociationOutcome::created)
      landmark_of[seen.feature] = seen.landmark;
  return landmark_of;
}

}  // namespace

BackgroundMapSmoothing::BackgroundMapSmoothing(const FastSlamSettings& settings)
    : smoother_(settings), deform_closed_loops_(settings.bend_closed_loops) {}

void BackgroundMapSmoothing::add(Utime utime, const Motion& odometry, const std::vector<FeaturePoint>& points,
                                 const StepResult& result) {
  now_ = utime;
  if (smoother_ && !add_keyframe(utime, odometry, points, result)) smoother_.reset();
  loop_open_ = smoother_ && deform_closed_loops_ && (loop_open_ || result.loop_closed);
  if (loop_open_ && !running_) begin();
}

bool BackgroundMapSmoothing::add_keyframe(Utime utime, const Motion& odometry,
                                          const std::vector<FeaturePoint>& points, const StepResult& result) {
  const std::map<int, std::int64_t> landmark_of = believed_landmarks(result);
  std::vector<PointObservation> observations;
  for (const FeaturePoint& point : points) {
    if (point.is_bearing()) continue;
    if (point.measurement.kind != MeasurementKind::point) return false;
    const auto landmark = landmark_of.find(point.feature);
    if (landmark != landmark_of.end()) observations.push_back({landmark->second, point.measurement});
  }
  // At a closed loop the odometry ties what was mapped astray to what is there: the loop deforms it all.
  std::optional<Motion> believed;
  if ((result.status != TrackStatus::relocalised || result.loop_closed) && !result.slipped)
    believed = odometry;
  smoother_->add(utime, result.T_world_best, believed, observations, result.loop_closed);
  return true;
}

bool BackgroundMapSmoothing::begin_on_request() {
  if (!smoother_ || smoother_->keyframes() < 2) return false;
  if (!running_) begin();
  running_->requested = true;
  return true;
}

void BackgroundMapSmoothing::begin() {
  running_ = Running{std::async(std::launch::async, [copy = *smoother_] { return copy.solve(); }),
                     now_ + smoothing_time};
  loop_open_ = false;
}

std::optional<BackgroundMapSmoothing::Result> BackgroundMapSmoothing::take_over_when_due(Utime now) {
  if (!running_ || now < running_->due) return std::nullopt;
  Result result{running_->result.get(), running_->requested};
  running_.reset();
  return result;
}

std::optional<MapSmoothing> BackgroundMapSmoothing::smooth() {
  running_.reset();  // this is newer
  return smoother_ ? smoother_->solve() : std::nullopt;
}

}  // namespace lcmslam
