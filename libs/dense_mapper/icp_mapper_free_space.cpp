// IcpMapper: what moved away leaves the map, and then the keyframes' clouds.

#include <lcmslam/dense_mapper/icp_mapper.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t worth_a_sweep = 50;  // places
constexpr std::size_t worth_telling = 50;  // one of so many of a keyframe's points
constexpr double seen_from = 1.5;  // times the filter's range: so far from its camera a keyframe knows

}  // namespace

void IcpMapper::look_through(const Cloud& cloud, const Eigen::Isometry3d& T_world_camera) {
  if (!settings_.free_space.enabled || thesis_) return;
  if (!bending_.valid()) {  // else another thread reads the map
    const FreeSpaceView view(cloud, settings_.free_space);
    const auto gone = map_->look_through(view, T_world_camera, settings_.free_space, looks_++);
    gone_.insert(gone_.end(), gone.begin(), gone.end());
  }
  if (!swept_.empty())
    clean_next_keyframe();
  else if (gone_.size() >= worth_a_sweep)
    begin_sweep();
}

void IcpMapper::begin_sweep() {
  swept_.insert(swept_.end(), gone_.begin(), gone_.end());
  gone_.clear();
  next_swept_ = 0;
  index_swept();
}

// The next one from which some of the places can be seen. Not while clouds wait to join others: they would
// bring back what an heir that is clean already has lost.
void IcpMapper::clean_next_keyframe() {
  if (!retired_.empty()) return;
  const double range = seen_from * settings_.filter.max_range;
  while (next_swept_ < keyframes_.size()) {
    Keyframe& keyframe = keyframes_[next_swept_++];
    const Eigen::Vector3f centre = keyframe.T_world_camera.translation().cast<float>();
    if (static_cast<double>(swept_box_.exteriorDistance(centre)) > range) continue;
    clean(keyframe);
    return;
  }
  swept_.clear();
}

void IcpMapper::index_swept() {
  swept_voxels_.clear(7 * swept_.size());
  swept_box_.setEmpty();
  const auto inverse_size = static_cast<float>(1 / settings_.map.voxel_size);
  for (const VoxelMap::Gone& place : swept_) {
    if (!voxel_exists(place.point, inverse_size)) continue;
    swept_box_.extend(place.point);
    const Eigen::Vector3i voxel = voxel_of(place.point, inverse_size);
    swept_voxels_.insert(voxel_key(voxel), 0);
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1})
        swept_voxels_.insert(voxel_key(voxel + side * Eigen::Vector3i::Unit(axis)), 0);
  }
}

// Points where surfels have gone, unless the map still knows a surface there.
void IcpMapper::clean(Keyframe& keyframe) {
  const Eigen::Isometry3f T = keyframe.T_world_camera.cast<float>();
  const auto size = static_cast<float>(settings_.map.voxel_size);
  TargetPoint found;
  std::vector<bool> gone(keyframe.cloud.size(), false);
  std::size_t count = 0;
  for (std::size_t i = 0; i < gone.size(); ++i) {
    const Eigen::Vector3f p = T * keyframe.cloud.points[i];
    if (!voxel_exists(p, 1 / size) ||
        swept_voxels_.find(voxel_key(voxel_of(p, 1 / size))) == VoxelIndex::none)
      continue;
    gone[i] = !map_->find(p, size, found);
    count += gone[i] ? 1 : 0;
  }
  if (count == 0) return;
  keyframe.cloud = kept_points(keyframe.cloud, [&](std::size_t i) { return !gone[i]; });
  keyframe.changed += count;
}

std::vector<std::size_t> IcpMapper::take_changed(bool all) {
  std::vector<std::size_t> changed;
  for (std::size_t i = 0; i < keyframes_.size(); ++i) {
    Keyframe& keyframe = keyframes_[i];
    if (keyframe.changed == 0 || (!all && keyframe.changed * worth_telling < keyframe.cloud.size())) continue;
    keyframe.changed = 0;
    changed.push_back(i);
  }
  return changed;
}

}  // namespace lcmslam
