#include <lcmslam/live_map/live_planes.hpp>

#include <lcmslam/imaging/io/codec.hpp>

namespace lcmslam {
namespace {

std::size_t bytes_of(const EncodedImage& labels, const std::vector<FramePlane>& planes) {
  return labels.bytes.size() + planes.size() * sizeof(FramePlane);
}

}  // namespace

LivePlanes::LivePlanes(const RgbdCalibration& calibration, const LiveMapSettings& settings)
    : settings_(settings),
      finder_(std::make_shared<FramePlaneFinder>(calibration, settings.frame_planes)),
      moved_(settings.moved_distance, settings.moved_angle),
      map_(settings.planes) {}

void LivePlanes::look_through(const RgbdCalibration& calibration) {
  finder_ = std::make_shared<FramePlaneFinder>(calibration, settings_.frame_planes);
}

void LivePlanes::insert(const Keyframe& keyframe, PlaneMap& map) {
  map.insert({keyframe.planes, decode_gray(keyframe.labels)}, keyframe.finder->cells(), keyframe.T_map_depth);
}

void LivePlanes::keep(int keyframe, const cv::Mat& depth, const Eigen::Isometry3d& T_map_depth) {
  frame();
  FramePlanes found = (*finder_)(depth);
  Keyframe kept{finder_, found.planes, encode_amplitude(found.labels, 0), T_map_depth};
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    map_.insert(found, finder_->cells(), T_map_depth);
    kept_bytes_ += bytes_of(kept.labels, kept.planes);
    if (const auto before = keyframes_.find(keyframe); before != keyframes_.end())
      drop(before);
    else if (keyframes_.size() >= static_cast<std::size_t>(settings_.occupancy.max_keyframes))
      drop(keyframes_.begin());
  }
  keyframes_[keyframe] = std::move(kept);
  moved_.add(keyframe, T_map_depth);
  if (making_.valid()) meanwhile_.push_back(keyframe);
}

void LivePlanes::drop(Keyframes::iterator keyframe) {
  kept_bytes_ -= bytes_of(keyframe->second.labels, keyframe->second.planes);
  moved_.forget(keyframe->first);
  keyframes_.erase(keyframe);
}

void LivePlanes::forget(const std::vector<int>& keyframes) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const int id : keyframes) {
    moved_.give_up(id);
    if (const auto found = keyframes_.find(id); found != keyframes_.end()) drop(found);
  }
}

void LivePlanes::frame() {
  take_over(false);
  moved_.frame();
  if (!making_.valid() && moved_.due()) put_together_anew();
}

void LivePlanes::correct(const std::map<int, Eigen::Isometry3d>& T_map_depth) {
  moved_.correct(T_map_depth);
  take_over(false);
  if (!making_.valid() && moved_.due()) put_together_anew();
}

void LivePlanes::catch_up() {
  take_over(false);
  if (!making_.valid() && moved_.moved()) put_together_anew();
}

void LivePlanes::settle() {
  take_over(true);
  if (!moved_.moved()) return;
  put_together_anew();
  take_over(true);
}

void LivePlanes::put_together_anew() {
  for (const auto& [id, T] : moved_.take()) keyframes_.at(id).T_map_depth = T;
  making_ = std::async(settings_.background ? std::launch::async : std::launch::deferred,
                       [keyframes = keyframes_, settings = settings_.planes] {
                         PlaneMap map(settings);
                         for (const auto& [id, keyframe] : keyframes) insert(keyframe, map);
                         return map;
                       });
  if (!settings_.background) take_over(true);
}

void LivePlanes::take_over(bool wait) {
  if (!making_.valid()) return;
  if (!wait && making_.wait_for(std::chrono::seconds(0)) == std::future_status::timeout) return;
  PlaneMap made = making_.get();
  for (const int id : meanwhile_)
    if (const auto found = keyframes_.find(id); found != keyframes_.end()) insert(found->second, made);
  meanwhile_.clear();
  const std::lock_guard<std::mutex> lock(mutex_);
  map_ = std::move(made);
}

std::vector<PlanePatch> LivePlanes::patches() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return map_.patches();
}

std::size_t LivePlanes::memory_bytes() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return map_.memory_bytes() + kept_bytes_;
}

}  // namespace lcmslam
