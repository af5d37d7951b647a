#include <lcmslam/dense_mapper/keyframe_store.hpp>

#include <algorithm>

#include <lcmslam/dense_mapper/by_node.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t worth_publishing = 50;  // a change of one of so many of a keyframe's points
constexpr double coarsest_voxel = 1;          // m
constexpr double filled_after_thinning = 0.9;

}  // namespace

KeyframeStore::KeyframeStore(const DenseMapperSettings& settings) : settings_(settings) {}

bool KeyframeStore::is_due(const Eigen::Isometry3d& T_world_camera, double overlap) const {
  const double share = overlap < settings_.keyframe_overlap ? 0.5 : 1.0;
  return std::all_of(keyframes_.begin(), keyframes_.end(),
                     [&](const Keyframe& k) { return is_far(T_world_camera, k.T_world_camera, share); });
}

bool KeyframeStore::is_far(const Eigen::Isometry3d& T_world_camera, const Eigen::Isometry3d& T_world_other,
                           double share) const {
  return distance_between(T_world_other, T_world_camera) >= share * settings_.keyframe_distance ||
         angle_between(T_world_other, T_world_camera) >= share * settings_.keyframe_angle;
}

void KeyframeStore::add(int node, Utime utime, const Eigen::Isometry3d& T_world_camera,
                        const ColouredCloud& cloud) {
  settle();
  keyframes_.push_back({node, utime, T_world_camera, voxel_filtered(cloud, settings_.keyframe_voxel),
                        settings_.keyframe_voxel});
  ++made_;
  bound(T_world_camera);
}

void KeyframeStore::begin(int node, Utime utime, const Eigen::Isometry3d& T_world_camera) {
  settle();
  keyframes_.push_back({node, utime, T_world_camera, {}, 0});
  ++made_;
  bound(T_world_camera);
}

void KeyframeStore::grow(const ColouredCloud& cloud) {
  Keyframe& newest = keyframes_.back();
  append(transformed(cloud, newest.T_world_camera.inverse()), newest.cloud);
  growing_ += cloud.size();
}

void KeyframeStore::settle() {
  if (!keyframes_.empty()) keyframes_.back().changed += growing_;
  growing_ = 0;
}

// Twice the voxel, about a quarter of the points: those far away first, until a tenth of the limit is free.
void KeyframeStore::bound(const Eigen::Isometry3d& T_world_camera) {
  double points = 0;
  for (const Keyframe& keyframe : keyframes_) points += static_cast<double>(keyframe.cloud.size());
  if (points <= settings_.keyframe_points) return;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < keyframes_.size(); ++i)
    order.emplace_back(-distance_between(keyframes_[i].T_world_camera, T_world_camera), i);
  std::sort(order.begin(), order.end());
  bool thinned = true;
  while (thinned) {
    thinned = false;
    for (const auto& [nearness, i] : order) {
      Keyframe& keyframe = keyframes_[i];
      if (points <= filled_after_thinning * settings_.keyframe_points) return;
      if (keyframe.voxel > coarsest_voxel) continue;
      points -= static_cast<double>(keyframe.cloud.size());
      keyframe.voxel = std::max(2 * keyframe.voxel, settings_.keyframe_voxel);
      keyframe.cloud = voxel_filtered(keyframe.cloud, keyframe.voxel);
      points += static_cast<double>(keyframe.cloud.size());
      thinned = true;
    }
  }
}

void KeyframeStore::begin_sweep() {
  for (Keyframe& keyframe : keyframes_) keyframe.to_sweep = true;
  for (Keyframe& keyframe : retired_) keyframe.to_sweep = true;
}

void KeyframeStore::swept(std::size_t i, const std::vector<bool>& gone) {
  Keyframe& keyframe = keyframes_[i];
  keyframe.to_sweep = false;
  const auto count = static_cast<std::size_t>(std::count(gone.begin(), gone.end(), true));
  if (count == 0) return;
  keyframe.cloud = kept_points(keyframe.cloud, [&](std::size_t k) { return !gone[k]; });
  keyframe.changed += count;
}

void KeyframeStore::deform(const KeyframeGraph::Correction& correction) {
  const auto move = [&](Keyframe& keyframe) {
    keyframe.T_world_camera = of_node(correction, keyframe.node) * keyframe.T_world_camera;
  };
  std::for_each(keyframes_.begin(), keyframes_.end(), move);
  std::for_each(retired_.begin(), retired_.end(), move);
}

void KeyframeStore::thin(const KeyframeGraph::Thinned& thinned) {
  settle();
  for (Keyframe& keyframe : retired_) keyframe.node = of_node(thinned.index, keyframe.node);
  std::vector<Keyframe> kept;
  for (Keyframe& keyframe : keyframes_) {
    const bool gone = thinned.gone[static_cast<std::size_t>(keyframe.node)];
    keyframe.node = of_node(thinned.index, keyframe.node);
    if (gone)
      retired_.push_back(std::move(keyframe));
    else
      kept.push_back(std::move(keyframe));
  }
  keyframes_ = std::move(kept);
}

// The points become as coarse as their successor's.
void KeyframeStore::merge_next() {
  if (retired_.empty()) return;
  const Keyframe retired = std::move(retired_.front());
  retired_.pop_front();
  if (retired.cloud.size() == 0) return;
  Keyframe& successor = successor_of(retired);
  append(transformed(retired.cloud, successor.T_world_camera.inverse() * retired.T_world_camera),
         successor.cloud);
  if (successor.voxel > 0) successor.cloud = voxel_filtered(successor.cloud, successor.voxel);
  successor.changed += retired.cloud.size();
  successor.to_sweep = successor.to_sweep || retired.to_sweep;
}

KeyframeStore::Keyframe& KeyframeStore::successor_of(const Keyframe& retired) {
  const auto gap = [&](const Keyframe& k) {
    return distance_between(k.T_world_camera, retired.T_world_camera) / settings_.keyframe_distance +
           angle_between(k.T_world_camera, retired.T_world_camera) / settings_.keyframe_angle;
  };
  return *std::min_element(keyframes_.begin(), keyframes_.end(),
                           [&](const Keyframe& a, const Keyframe& b) { return gap(a) < gap(b); });
}

std::vector<std::size_t> KeyframeStore::take_changed(bool all) {
  if (all) settle();
  std::vector<std::size_t> changed;
  for (std::size_t i = 0; i < keyframes_.size(); ++i) {
    Keyframe& keyframe = keyframes_[i];
    const bool notable = keyframe.changed * worth_publishing >= keyframe.cloud.size();
    if (keyframe.changed == 0 || (!all && !notable)) continue;
    keyframe.changed = 0;
    changed.push_back(i);
  }
  return changed;
}

std::size_t KeyframeStore::memory_bytes() const {
  std::size_t bytes = keyframes_.capacity() * sizeof(Keyframe);
  for (const Keyframe& keyframe : keyframes_) bytes += lcmslam::memory_bytes(keyframe.cloud);
  for (const Keyframe& keyframe : retired_) bytes += sizeof(Keyframe) + lcmslam::memory_bytes(keyframe.cloud);
  return bytes;
}

}  // namespace lcmslam
