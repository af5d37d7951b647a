#include <lcmslam/fastslam/smoothing/background_path_smoothing.hpp>

#include <algorithm>
#include <utility>

namespace lcmslam {
namespace {

constexpr std::uint64_t smoothing_stream = 0x736d6f6f7468;
constexpr Utime time_per_pose = 100;  // us that the solver has, for each pose; takes about 70
constexpr double urgent_factor = 2;   // times its share of a core: where few lineages are left

}  // namespace

BackgroundPathSmoothing::BackgroundPathSmoothing(const FastSlamSettings& settings)
    : settings_(settings), smoother_(settings), stream_(settings.seed, smoothing_stream) {}

bool BackgroundPathSmoothing::fits(const std::vector<FeaturePoint>& points) {
  return std::all_of(points.begin(), points.end(), [](const FeaturePoint& point) {
    return point.landmark_id >= 0 && point.measurement.kind != MeasurementKind::point;
  });
}

void BackgroundPathSmoothing::add(StepRecord step) {
  now_ = step.utime;
  if (running_)
    since_.push_back(std::move(step));
  else
    add_to_path(step);
}

// All observations of known identity, believed by the filter or not. The values are as measured, the
// covariances those that the filter used.
void BackgroundPathSmoothing::add_to_path(const StepRecord& step) {
  // First, since what has died may have been born again in the same step.
  for (const std::int32_t id : step.forgotten) smoother_.forget(id);
  std::vector<IdentifiedMeasurement> observations;
  for (std::size_t i = 0; i < step.used.size(); ++i) {
    observations.push_back({step.used[i].landmark_id, step.measured[i].measurement});
    observations.back().measurement.covariance = step.used[i].measurement.covariance;
  }
  smoother_.add(step.utime, step.odometry, step.calibration_jacobian, observations, step.T_world_robot,
                step.covariance);
}

// Few lineages may lead far astray within seconds (Victoria Park: two lineages, a spread of 0.2 m, an error
// of 10 m). Where observations are rare and come together the solver has rested, and is there at once.
void BackgroundPathSmoothing::begin_when_due(bool reunion, bool few_lineages) {
  reunited_ = reunited_ || reunion;
  if (running_ || smoother_.size() < 2 || (!reunited_ && !few_lineages)) return;
  const double share = (few_lineages ? urgent_factor : 1) * settings_.rejuvenation_share;
  if (share * static_cast<double>(now_ - begun_at_) >= static_cast<double>(solving_time())) begin();
}

bool BackgroundPathSmoothing::begin_on_request() {
  if (!running_ && smoother_.size() < 2) return false;
  if (!running_) begin();
  running_->requested = true;
  return true;
}

Utime BackgroundPathSmoothing::solving_time() const {
  return time_per_pose * static_cast<Utime>(smoother_.size());
}

void BackgroundPathSmoothing::begin() {
  const auto draw = [this] {
    SmoothedPath result;
    result.cost = smoother_.solve();
    result.samples = smoother_.sample(static_cast<std::size_t>(settings_.particles), stream_,
                                      result.calibration_covariance);
    result.sensor = smoother_.sensor();
    result.path = smoother_.path();
    return result;
  };
  running_ = Running{std::async(std::launch::async, draw), now_ + solving_time()};
  begun_at_ = now_;
  reunited_ = false;
}

SmoothedPath BackgroundPathSmoothing::take_over() {
  SmoothedPath result = running_->result.get();
  result.requested = running_->requested;
  running_.reset();
  result.since = std::exchange(since_, {});
  for (const StepRecord& step : result.since) add_to_path(step);
  return result;
}

SmoothedPath BackgroundPathSmoothing::smooth() {
  begin();
  return take_over();
}

}  // namespace lcmslam
