// IcpMapper: what redundant keyframes leave behind.

#include <algorithm>

#include <lcmslam/dense_mapper/icp_mapper.hpp>

namespace lcmslam {

// Nodes that others cover go from the graph; what belongs to them belongs to the nearest keyframe then.
bool IcpMapper::thin() {
  if (!retired_.empty()) merge_next_retired();
  if (bending_.valid()) return false;  // the map is being read, and the nodes' places are about to change
  const auto thinned = graph_.thin({settings_.keyframe_distance, settings_.keyframe_angle});
  if (!thinned) return false;
  const auto renumber = [&](int& node) {
    node = thinned->index[std::min(static_cast<std::size_t>(node), thinned->index.size() - 1)];
  };
  for (Keyframe& keyframe : retired_) renumber(keyframe.id);
  std::vector<Keyframe> kept;
  for (Keyframe& keyframe : keyframes_) {
    const bool gone = thinned->gone[static_cast<std::size_t>(keyframe.id)];
    renumber(keyframe.id);
    if (gone)
      retired_.push_back(std::move(keyframe));
    else
      kept.push_back(std::move(keyframe));
  }
  keyframes_ = std::move(kept);
  for (auto* places : {&gone_, &swept_})
    for (VoxelMap::Gone& place : *places) renumber(place.anchor);
  next_swept_ = 0;  // they have moved up
  anchor_.renumber(thinned->gone, thinned->index);
  map_->renumber_anchors(thinned->index);
  return true;
}

// Its points join the nearest keyframe's, as coarse as those are.
void IcpMapper::merge_next_retired() {
  const Keyframe retired = std::move(retired_.front());
  retired_.pop_front();
  if (retired.cloud.size() == 0) return;
  const auto gap = [&](const Keyframe& k) {
    return distance_between(k.T_world_camera, retired.T_world_camera) / settings_.keyframe_distance +
           angle_between(k.T_world_camera, retired.T_world_camera) / settings_.keyframe_angle;
  };
  const auto heir = std::min_element(keyframes_.begin(), keyframes_.end(),
                                     [&](const Keyframe& a, const Keyframe& b) { return gap(a) < gap(b); });
  append(transformed(retired.cloud, heir->T_world_camera.inverse() * retired.T_world_camera), heir->cloud);
  heir->cloud = voxel_filtered(heir->cloud, heir->voxel);
  heir->changed += retired.cloud.size();
}

std::size_t IcpMapper::memory_bytes() const {
  std::size_t bytes = map_->memory_bytes() + anchor_.memory_bytes() + graph_.memory_bytes() +
                      keyframes_.capacity() * sizeof(Keyframe) +
                      (gone_.capacity() + swept_.capacity()) * sizeof(VoxelMap::Gone) +
                      swept_voxels_.memory_bytes();
  for (const Keyframe& keyframe : keyframes_) bytes += lcmslam::memory_bytes(keyframe.cloud);
  for (const Keyframe& keyframe : retired_) bytes += sizeof(Keyframe) + lcmslam::memory_bytes(keyframe.cloud);
  for (const Insertion& insertion : insertions_) bytes += lcmslam::memory_bytes(insertion.cloud);
  return bytes;
}

}  // namespace lcmslam
