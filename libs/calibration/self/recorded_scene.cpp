#include <lcmslam/calibration/self/recorded_scene.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include <lcmslam/calibration/self/landmark_tracks.hpp>
#include <lcmslam/imaging/folded_depth.hpp>
#include <lcmslam/rgbd/camera_motion.hpp>
#include <lcmslam/rgbd/describe_frame.hpp>
#include <lcmslam/surf/surf.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t fewest_keyframes = 5;
constexpr std::size_t most_kept = 3;  // times as many as are taken

constexpr Utime whole_recording = 100'000'000'000;  // us

double seconds(Utime from, Utime to) {
  return 1e-6 * static_cast<double>(to - from);
}

SurfSettings surf_settings(int max_features) {
  SurfSettings settings;
  settings.budget.max_features = max_features;
  return settings;
}

cv::Mat inverse_of(const cv::Mat& millimetres, const RgbdCalibration& c) {
  cv::Mat inverse(millimetres.size(), CV_32FC1);
  for (int v = 0; v < millimetres.rows; ++v) {
    const auto* from = millimetres.ptr<std::uint16_t>(v);
    auto* to = inverse.ptr<float>(v);
    for (int u = 0; u < millimetres.cols; ++u) {
      const double z = 1e-3 * from[u];
      to[u] = z >= c.depth_min && z <= c.depth_max ? static_cast<float>(1 / z) : 0.F;
    }
  }
  return inverse;
}

/// Smoothed by as much as makes its values between pixels agree.
cv::Mat smooth_grey(const cv::Mat& colour) {
  constexpr double sigma = 0.7;  // pixels
  cv::Mat grey;
  cv::cvtColor(colour, grey, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(grey, grey, {}, sigma);
  return grey;
}

}  // namespace

struct RecordedScene::Detector {
  Detector(const RgbdCalibration& start, int max_features)
      : registration(start), folded(start), filter(start), surf(surf_settings(max_features)) {}
  DepthRegistration registration;
  FoldedDepthFilter folded;
  DepthFilter filter;
  Surf surf;
};

RecordedScene::RecordedScene(const RgbdCalibration& start, const RecordedSceneSettings& settings)
    : start_(start),
      settings_(settings),
      detector_(std::make_unique<Detector>(start, settings.max_features)),
      odometry_({}, Random(settings.seed)),
      wheels_(whole_recording) {}

RecordedScene::~RecordedScene() = default;

void RecordedScene::add(const RgbdFrame& frame) {
  ++frames_;
  if (frame.colour.empty() || frame.depth.empty()) return;
  if (!path_.empty() && frame.utime <= path_.back().utime)
    return;  // time that began anew is another recording
  RgbdFrame filtered = frame;
  filtered.depth = frame.depth.clone();
  detector_->folded(filtered.depth, filtered.amplitude);
  detector_->filter(filtered.depth, filtered.amplitude);
  FeatureFrame features =
      describe_frame(filtered, detector_->registration, Eigen::Isometry3d::Identity(), detector_->surf);
  if (const auto step = turn_.add(features)) turns_.push_back(*step);
  const auto sample = odometry_.update(features);
  if (!sample || odometry_.report().status != VisualStatus::tracking) return;
  const Eigen::Isometry3d T = sample->T_odom_robot * features.T_robot_camera;
  path_.push_back({frame.utime, T});
  if (!is_keyframe(T)) return;
  last_keyframe_ = T;
  if (!is_to_be_kept()) return;
  Keyframe keyframe{path_.size() - 1, std::move(features), {}, filtered.depth};
  keyframe.observed.grey = smooth_grey(frame.colour);
  keyframe.observed.utime = frame.utime;
  keyframe.observed.T_world_camera = T;
  keyframe.observed.depth_lag = seconds(frame.utime, frame.depth_utime);
  keyframes_.push_back(std::move(keyframe));
}

void RecordedScene::add(const MotionSample& odometry) {
  wheels_came_ = true;
  // A buffer forgets all when time goes back: one late message would take the wheels of all before it.
  const bool is_late = !wheels_.empty() && odometry.utime <= wheels_.newest();
  if (start_.has_mount && !is_late) wheels_.add(odometry);
}

bool RecordedScene::is_keyframe(const Eigen::Isometry3d& T) const {
  if (!last_keyframe_) return true;
  return distance_between(*last_keyframe_, T) > settings_.keyframe_translation ||
         angle_between(*last_keyframe_, T) > settings_.keyframe_rotation;
}

/// Makes room, so that those of a long recording stay few and spread evenly over all of it.
bool RecordedScene::is_to_be_kept() {
  const std::size_t number = keyframes_seen_++;
  if (number % keep_each_ != 0) return false;
  if (keyframes_.size() < most_kept * static_cast<std::size_t>(settings_.keyframes)) return true;
  for (std::size_t i = 1; 2 * i < keyframes_.size(); ++i) keyframes_[i] = std::move(keyframes_[2 * i]);
  keyframes_.resize((keyframes_.size() + 1) / 2);
  keep_each_ *= 2;
  return number % keep_each_ == 0;
}

// Over the same time before and after, so that an acceleration does no harm.
std::optional<RecordedScene::Velocity> RecordedScene::velocity_at(std::size_t pose) const {
  constexpr double longest = 1.1 / slowest_images;  // s, to each side: a camera's period is not exact
  std::size_t before = pose, after = pose;
  const Utime now = path_[pose].utime, window = static_cast<Utime>(1e6 * settings_.velocity_window);
  if (const auto motion = wheels_.between(now - window, now + window))
    return Velocity{
        se3_log(camera_motion(*motion, start_.T_robot_camera)) / seconds(now - window, now + window),
        settings_.wheel_turn_noise};
  while (before > 0 && seconds(path_[before].utime, now) < settings_.velocity_window) --before;
  while (after + 1 < path_.size() && seconds(now, path_[after].utime) < settings_.velocity_window) ++after;
  const double past = seconds(path_[before].utime, now), coming = seconds(now, path_[after].utime);
  if (!(past > 0 && coming > 0 && past < longest && coming < longest)) return std::nullopt;
  return Velocity{
      se3_log(path_[before].T_world_camera.inverse() * path_[after].T_world_camera) / (past + coming),
      settings_.image_turn_noise};
}

Vector6d RecordedScene::motion_between(std::size_t pose, std::size_t later) const {
  if (const auto motion = wheels_.between(path_[pose].utime, path_[later].utime))
    return se3_log(camera_motion(*motion, start_.T_robot_camera));
  return se3_log(path_[pose].T_world_camera.inverse() * path_[later].T_world_camera);
}

/// Of the earlier keyframes the last ones, and those that look at the same place.
std::vector<std::size_t> RecordedScene::views_of(const std::vector<const Keyframe*>& keyframes,
                                                 std::size_t of) const {
  const auto neighbours = static_cast<std::size_t>(settings_.neighbours);
  const std::size_t first = of > neighbours ? of - neighbours : 0;
  std::vector<std::size_t> views;
  for (std::size_t i = first; i < of; ++i) views.push_back(i);
  std::vector<std::pair<double, std::size_t>> others;
  const Eigen::Isometry3d& T = keyframes[of]->observed.T_world_camera;
  for (std::size_t i = 0; i < first; ++i) {
    const double way = distance_between(keyframes[i]->observed.T_world_camera, T),
                 turn = angle_between(keyframes[i]->observed.T_world_camera, T);
    if (way < settings_.view_distance && turn < settings_.view_angle)
      others.emplace_back(way / settings_.view_distance + turn / settings_.view_angle, i);
  }
  std::sort(others.begin(), others.end());
  for (std::size_t i = 0; i < std::min(others.size(), static_cast<std::size_t>(settings_.others)); ++i)
    views.push_back(others[i].second);
  return views;
}

/// Hz, of the images on the path: the median, as a path has gaps.
double RecordedScene::image_rate() const {
  std::vector<double> periods;
  for (std::size_t i = 1; i < path_.size(); ++i)
    periods.push_back(seconds(path_[i - 1].utime, path_[i].utime));
  if (periods.empty()) return 0;
  const auto middle = periods.begin() + static_cast<std::ptrdiff_t>(periods.size() / 2);
  std::nth_element(periods.begin(), middle, periods.end());
  return 1 / *middle;
}

std::string RecordedScene::why_too_few(std::size_t keyframes, int without_velocity) const {
  char text[400];
  std::snprintf(text, sizeof text,
                "self calibration: %d frames gave %zu keyframes on a tracked path; at least %zu are needed: ",
                frames_, keyframes, fewest_keyframes);
  if (without_velocity == 0) return std::string(text) + "the camera must move, see texture and have depth";
  char reason[300];
  std::snprintf(
      reason, sizeof reason,
      "%d more have no velocity, as images come %.1f times a second: record %.0f a second or more, or "
      "wheels and the camera's mount",
      without_velocity, image_rate(), slowest_images);
  return std::string(text) + reason;
}

SceneObservations RecordedScene::observations() const {
  std::vector<const Keyframe*> keyframes;
  std::vector<ObservedKeyframe> observed;
  int without_velocity = 0;
  const std::size_t most = std::min(keyframes_.size(), static_cast<std::size_t>(settings_.keyframes));
  for (std::size_t n = 0; n < most; ++n) {
    const std::size_t i = n * keyframes_.size() / most;
    const auto velocity = velocity_at(keyframes_[i].pose);
    if (!velocity) {
      ++without_velocity;
      continue;
    }
    const std::optional<Vector6d> motion =
        keyframes.empty() ? std::nullopt
                          : std::optional(motion_between(keyframes.back()->pose, keyframes_[i].pose));
    keyframes.push_back(&keyframes_[i]);
    observed.push_back(keyframes_[i].observed);
    observed.back().inverse_depth = inverse_of(keyframes_[i].depth, start_);
    observed.back().twist = velocity->twist;
    observed.back().turn_noise = velocity->turn_noise;
    observed.back().motion = motion;
  }
  if (keyframes.size() < fewest_keyframes)
    throw std::runtime_error(why_too_few(keyframes.size(), without_velocity));

  LandmarkTracks tracks(start_, settings_.match_gate, settings_.seed);
  for (std::size_t b = 0; b < keyframes.size(); ++b) {
    tracks.add(keyframes[b]->features, observed[b].T_world_camera);
    for (const std::size_t a : views_of(keyframes, b)) tracks.match_last(a);
  }
  SceneObservations scene;
  scene.landmarks = tracks.landmarks(static_cast<std::size_t>(settings_.landmarks));
  scene.keyframes = std::move(observed);
  return scene;
}

}  // namespace lcmslam
