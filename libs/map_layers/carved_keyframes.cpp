#include <lcmslam/map_layers/carved_keyframes.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr int kept_columns = 160;
constexpr double millimetres = 1000;

// One pixel of each square of `factor`, the one in its middle: a mean of depths would lie where nothing is.
cv::Mat every(int factor, const cv::Mat& depth) {
  cv::Mat metres, small(depth.rows / factor, depth.cols / factor, CV_16SC1);
  depth.convertTo(metres, CV_32F, depth.type() == CV_32FC1 ? millimetres : 1.0);
  for (int v = 0; v < small.rows; ++v)
    for (int u = 0; u < small.cols; ++u) {
      const float value = metres.at<float>(factor * v + factor / 2, factor * u + factor / 2);
      const bool fits = std::abs(value) < 32767;  // not NaN either
      small.at<std::int16_t>(v, u) = fits ? static_cast<std::int16_t>(std::lround(value)) : std::int16_t{0};
    }
  return small;
}

// The camera whose pixels those are.
CameraModel every(int factor, CameraModel camera) {
  camera.width /= factor, camera.height /= factor;
  camera.fx /= factor, camera.fy /= factor;
  const int first = factor / 2;  // of the pixels that are taken
  camera.cx = (camera.cx - first) / factor, camera.cy = (camera.cy - first) / factor;
  return camera;
}

}  // namespace

CarvedKeyframes::CarvedKeyframes(const OccupancySettings& settings) : settings_(settings) {
  check(settings_, "occupancy");
}

void CarvedKeyframes::add(int id, const cv::Mat& depth, const CameraModel& camera,
                          const Eigen::Isometry3d& T_map_camera) {
  const int factor = std::max(1, (camera.width + kept_columns / 2) / kept_columns);
  keyframes_[id] = {every(factor, depth), every(factor, camera), T_map_camera};
  while (keyframes_.size() > static_cast<std::size_t>(settings_.max_keyframes)) {
    keyframes_.erase(keyframes_.begin());
    ++forgotten_;
  }
}

void CarvedKeyframes::forget(int id) {
  keyframes_.erase(id);
}

OccupancyGrid CarvedKeyframes::carve_anew(const std::map<int, Eigen::Isometry3d>& corrected,
                                          const OccupancyGrid& carved) {
  OccupancyGrid anew(settings_);
  DepthCarver carver;
  for (auto& [id, keyframe] : keyframes_) {
    mark_gone(keyframe, carved);
    const auto found = corrected.find(id);
    if (found != corrected.end()) keyframe.T_map_camera = found->second;
    carver.carve(keyframe.depth, keyframe.camera, keyframe.T_map_camera, anew);
  }
  return anew;
}

void CarvedKeyframes::mark_gone(Keyframe& keyframe, const OccupancyGrid& carved) {
  const Eigen::Isometry3f T = keyframe.T_map_camera.cast<float>();
  for (int v = 0; v < keyframe.depth.rows; ++v)
    for (int u = 0; u < keyframe.depth.cols; ++u) {
      auto& depth = keyframe.depth.at<std::int16_t>(v, u);
      if (depth <= 0) continue;
      const Eigen::Vector3f p =
          static_cast<float>(depth / millimetres) * keyframe.camera.ray({u, v}).cast<float>();
      if (carved.state(Eigen::Vector3f(T * p)) == CellState::free) depth = static_cast<std::int16_t>(-depth);
    }
}

std::size_t CarvedKeyframes::memory_bytes() const {
  std::size_t bytes = 0;
  for (const auto& [id, keyframe] : keyframes_)
    bytes += keyframe.depth.total() * keyframe.depth.elemSize() + sizeof(Keyframe);
  return bytes;
}

}  // namespace lcmslam
