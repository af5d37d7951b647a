#include <lcmslam/live_map/live_planes.hpp>

#include <lcmslam/imaging/io/codec.hpp>

namespace lcmslam {
namespace {

void insert(const cv::Mat& depth, const Eigen::Isometry3d& T_map_depth, FramePlaneFinder& finder,
            PlaneMap& map) {
  const FramePlanes found = finder(depth);
  map.insert(found, finder.cells(), T_map_depth);
}

}  // namespace

LivePlanes::LivePlanes(const RgbdCalibration& calibration, const LiveMapSettings& settings)
    : calibration_(calibration),
      settings_(settings),
      finder_(calibration, settings.frame_planes),
      moved_(settings.moved_distance, settings.moved_angle),
      map_(settings.planes) {}

void LivePlanes::keep(int keyframe, const cv::Mat& depth, const Eigen::Isometry3d& T_map_depth) {
  take_over(false);
  const std::size_t most = static_cast<std::size_t>(settings_.occupancy.max_keyframes);
  if (keyframes_.size() >= most && keyframes_.count(keyframe) == 0) {
    kept_bytes_ -= keyframes_.begin()->second.depth.bytes.size();
    moved_.forget(keyframes_.begin()->first);
    keyframes_.erase(keyframes_.begin());
  }
  Keyframe& kept = keyframes_[keyframe];
  kept_bytes_ -= kept.depth.bytes.size();
  kept = {encode_depth(depth, 0), T_map_depth};
  kept_bytes_ += kept.depth.bytes.size();
  moved_.add(keyframe, T_map_depth);
  if (making_.valid()) meanwhile_.push_back(keyframe);

  const FramePlanes found = finder_(depth);
  const std::lock_guard<std::mutex> lock(mutex_);
  map_.insert(found, finder_.cells(), T_map_depth);
}

void LivePlanes::correct(const std::map<int, Eigen::Isometry3d>& T_map_depth) {
  moved_.correct(T_map_depth);
  take_over(false);
  if (!making_.valid() && moved_.due()) put_together_anew();
}

void LivePlanes::settle() {
  take_over(true);
  if (!moved_.due()) return;
  put_together_anew();
  take_over(true);
}

void LivePlanes::put_together_anew() {
  for (const auto& [id, T] : moved_.take()) keyframes_.at(id).T_map_depth = T;
  making_ = std::async(settings_.background ? std::launch::async : std::launch::deferred,
                       [keyframes = keyframes_, calibration = calibration_, settings = settings_] {
                         FramePlaneFinder finder(calibration, settings.frame_planes);
                         PlaneMap map(settings.planes);
                         for (const auto& [id, keyframe] : keyframes)
                           insert(decode_depth(keyframe.depth), keyframe.T_map_depth, finder, map);
                         return map;
                       });
  if (!settings_.background) take_over(true);
}

void LivePlanes::take_over(bool wait) {
  if (!making_.valid()) return;
  if (!wait && making_.wait_for(std::chrono::seconds(0)) == std::future_status::timeout) return;
  PlaneMap made = making_.get();
  for (const int id : meanwhile_)
    if (const auto found = keyframes_.find(id); found != keyframes_.end())
      insert(decode_depth(found->second.depth), found->second.T_map_depth, finder_, made);
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
