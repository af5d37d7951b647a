#include <lcmslam/map_layers/carved_keyframes.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr int kept_columns = 160;
constexpr double millimetres = 1000;
constexpr std::size_t least_dropped = 4096;  // cells a keyframe, before it is asked which of them are gone

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
  const CameraModel kept = every(factor, camera);
  keyframes_[id] = {every(factor, depth), kept, ray_table(kept), T_map_camera};
  while (keyframes_.size() > static_cast<std::size_t>(settings_.max_keyframes)) {
    keyframes_.erase(keyframes_.begin());
    ++forgotten_;
  }
}

void CarvedKeyframes::forget(int id) {
  keyframes_.erase(id);
}

void CarvedKeyframes::follow(int id, const Eigen::Isometry3d& T_map_camera,
                             const std::vector<OccupancyChange>& hits, const OccupancyGrid& carved) {
  const auto found = keyframes_.find(id);
  if (found == keyframes_.end()) return;
  if (!followed_ || followed_->id != id || !followed_->T_map_camera.isApprox(T_map_camera, 1e-9))
    look_at(id, T_map_camera);
  std::vector<Eigen::Vector3f>& also_seen = found->second.also_seen;
  const Eigen::Isometry3f T_camera_map = T_map_camera.inverse().cast<float>();
  for_each_cell(hits, [&](const Eigen::Vector3i& cell) {
    const auto next = static_cast<std::int32_t>(followed_->count);
    if (followed_->cells.insert(voxel_key(cell), next) != next) return;
    ++followed_->count;
    also_seen.emplace_back(T_camera_map * carved.centre_of(cell));
  });
  if (also_seen.size() < followed_->most) return;
  found->second.drop_gone(T_map_camera, carved);
  look_at(id, T_map_camera);
}

/// Frames hang on another keyframe, or on the same in another place. What the next keyframe has seen itself
/// the one before it need not keep.
void CarvedKeyframes::look_at(int id, const Eigen::Isometry3d& T_map_camera) {
  const auto inverse_size = static_cast<float>(1 / settings_.cell_size);
  const auto cell_of = [&, T = Eigen::Isometry3f(T_map_camera.cast<float>())](const Eigen::Vector3f& p) {
    return voxel_key(voxel_of(T * p, inverse_size));
  };
  Followed now{id, T_map_camera};
  const auto see = [&](const Eigen::Vector3f& p) {
    const auto next = static_cast<std::int32_t>(now.count);
    if (now.cells.insert(cell_of(p), next) == next) ++now.count;
  };
  const Keyframe& keyframe = keyframes_.at(id);
  for (int v = 0; v < keyframe.depth.rows; ++v)
    for (int u = 0; u < keyframe.depth.cols; ++u)
      if (const int depth = keyframe.depth.at<std::int16_t>(v, u); depth > 0)
        see(keyframe.point(u, v, depth));
  if (const auto last = followed_ && followed_->id != id ? keyframes_.find(followed_->id) : keyframes_.end();
      last != keyframes_.end()) {
    const Eigen::Isometry3f T_here_last = (T_map_camera.inverse() * followed_->T_map_camera).cast<float>();
    const auto is_seen = [&](const Eigen::Vector3f& p) {
      return now.cells.find(cell_of(T_here_last * p)) != VoxelIndex::none;
    };
    auto& cells = last->second.also_seen;
    cells.erase(std::remove_if(cells.begin(), cells.end(), is_seen), cells.end());
    cells.shrink_to_fit();
  }
  for (const Eigen::Vector3f& p : keyframe.also_seen) see(p);
  now.most = std::max(least_dropped, 2 * keyframe.also_seen.size());
  followed_ = std::move(now);
}

OccupancyGrid CarvedKeyframes::carve_anew(const std::map<int, Eigen::Isometry3d>& corrected,
                                          const OccupancyGrid& carved, const Eigen::Vector3f& place) {
  OccupancyGrid anew(settings_);
  DepthCarver carver;
  for (auto& [id, keyframe] : keyframes_) {
    keyframe.mark_gone(carved);
    keyframe.drop_gone(keyframe.T_map_camera, carved);
    const auto found = corrected.find(id);
    if (found != corrected.end()) keyframe.T_map_camera = found->second;
    carver.carve(keyframe.depth, keyframe.camera, keyframe.T_map_camera, anew);
    anew.make_room(place);
  }
  // After all images, which may have looked through it before it was there.
  for (const auto& [id, keyframe] : keyframes_) {
    HitCells hits;
    for (const Eigen::Vector3f& p : keyframe.also_seen)
      hits.add(anew.cell_of(keyframe.T_map_camera.cast<float>() * p));
    hits.occupy(anew);
  }
  return anew;
}

Eigen::Vector3f CarvedKeyframes::Keyframe::point(int u, int v, int millimetres_deep) const {
  const auto& ray = rays.at<cv::Vec2f>(v, u);
  return static_cast<float>(millimetres_deep / millimetres) * Eigen::Vector3f(ray[0], ray[1], 1);
}

/// In an image of its own: copies of these keyframes, in other threads, share the old one.
void CarvedKeyframes::Keyframe::mark_gone(const OccupancyGrid& carved) {
  depth = depth.clone();
  const Eigen::Isometry3f T = T_map_camera.cast<float>();
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      auto& value = depth.at<std::int16_t>(v, u);
      if (value > 0 && carved.state(Eigen::Vector3f(T * point(u, v, value))) == CellState::free)
        value = static_cast<std::int16_t>(-value);
    }
}

/// Of what frames saw, by a grid in which the keyframe stands at T.
void CarvedKeyframes::Keyframe::drop_gone(const Eigen::Isometry3d& T, const OccupancyGrid& carved) {
  const auto is_gone = [&, T = T.cast<float>()](const Eigen::Vector3f& p) {
    return carved.state(Eigen::Vector3f(T * p)) == CellState::free;
  };
  also_seen.erase(std::remove_if(also_seen.begin(), also_seen.end(), is_gone), also_seen.end());
}

std::size_t CarvedKeyframes::cells_of_frames() const {
  std::size_t cells = 0;
  for (const auto& [id, keyframe] : keyframes_) cells += keyframe.also_seen.size();
  return cells;
}

std::size_t CarvedKeyframes::memory_bytes() const {
  std::size_t bytes = followed_ ? followed_->cells.memory_bytes() : 0;
  for (const auto& [id, keyframe] : keyframes_)
    bytes += keyframe.depth.total() * keyframe.depth.elemSize() + sizeof(Keyframe) +
             keyframe.also_seen.capacity() * sizeof(Eigen::Vector3f);
  return bytes;
}

}  // namespace lcmslam
