#include <lcmslam/dense_mapper/changed_space.hpp>

#include <lcmslam/dense_mapper/by_node.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t worth_a_sweep = 50;  // places
constexpr double seen_from = 1.5;          // times the filter's range: the way to a corner of the image

}  // namespace

ChangedSpace::ChangedSpace(const DenseMapperSettings& settings)
    : enabled_(settings.free_space.enabled && settings.variant == VariantKind::modern),
      settings_(settings.free_space),
      seen_within_(seen_from * settings.filter.max_range),
      voxel_size_(static_cast<float>(settings.map.voxel_size)),
      inverse_size_(static_cast<float>(1 / settings.map.voxel_size)) {}

void ChangedSpace::look_through(const Cloud& cloud, const Eigen::Isometry3d& T_world_camera,
                                DeformableMap& map, KeyframeStore& keyframes, int first_node) {
  if (!enabled_) return;
  if (!map.deforming()) {
    const FreeSpaceView view(cloud, settings_);
    const auto gone = map.look_through(view, T_world_camera, settings_, looks_++, first_node);
    gone_.insert(gone_.end(), gone.begin(), gone.end());
  }
  if (sweeping())
    clean_next(map.voxels(), keyframes);
  else if (gone_.size() >= worth_a_sweep)
    begin_sweep(keyframes);
}

void ChangedSpace::finish(const VoxelMap& map, KeyframeStore& keyframes) {
  begin_sweep(keyframes);
  while (sweeping() && !keyframes.merging()) clean_next(map, keyframes);
}

void ChangedSpace::begin_sweep(KeyframeStore& keyframes) {
  swept_.insert(swept_.end(), gone_.begin(), gone_.end());
  gone_.clear();
  keyframes.begin_sweep();
  index();
}

// The voxels of the places and those beside them.
void ChangedSpace::index() {
  swept_voxels_.clear(7 * swept_.size());
  swept_box_.setEmpty();
  for (const VoxelMap::Gone& place : swept_) {
    if (!voxel_exists(place.point, inverse_size_)) continue;
    swept_box_.extend(place.point);
    const Eigen::Vector3i voxel = voxel_of(place.point, inverse_size_);
    swept_voxels_.insert(voxel_key(voxel), 0);
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1})
        swept_voxels_.insert(voxel_key(voxel + side * Eigen::Vector3i::Unit(axis)), 0);
  }
}

// The next one from which some of the places can be seen. Not while clouds wait to join others: they would
// bring back what a successor that is clean already has lost.
void ChangedSpace::clean_next(const VoxelMap& map, KeyframeStore& keyframes) {
  if (keyframes.merging()) return;
  for (std::size_t i = 0; i < keyframes.all().size(); ++i) {
    if (!keyframes.all()[i].to_sweep) continue;
    const Eigen::Vector3f centre = keyframes.all()[i].T_world_camera.translation().cast<float>();
    if (static_cast<double>(swept_box_.exteriorDistance(centre)) > seen_within_) {
      keyframes.swept(i);
      continue;
    }
    clean(i, map, keyframes);
    return;
  }
  swept_.clear();
}

// Points where surfels have gone, unless the map still knows a surface there.
void ChangedSpace::clean(std::size_t i, const VoxelMap& map, KeyframeStore& keyframes) const {
  const KeyframeStore::Keyframe& keyframe = keyframes.all()[i];
  const Eigen::Isometry3f T = keyframe.T_world_camera.cast<float>();
  TargetPoint found;
  std::vector<bool> gone(keyframe.cloud.size(), false);
  for (std::size_t k = 0; k < gone.size(); ++k) {
    const Eigen::Vector3f p = T * keyframe.cloud.points[k];
    if (!voxel_exists(p, inverse_size_)) continue;
    const bool touched = swept_voxels_.find(voxel_key(voxel_of(p, inverse_size_))) != VoxelIndex::none;
    gone[k] = touched && !map.find(p, voxel_size_, found);
  }
  keyframes.swept(i, gone);
}

void ChangedSpace::deform(const KeyframeGraph::Correction& correction) {
  for (auto* places : {&gone_, &swept_})
    for (VoxelMap::Gone& place : *places)
      place.point = of_node(correction, place.anchor).cast<float>() * place.point;
  if (sweeping()) index();
}

void ChangedSpace::renumber(const KeyframeGraph::Thinned& thinned) {
  for (auto* places : {&gone_, &swept_})
    for (VoxelMap::Gone& place : *places) place.anchor = of_node(thinned.index, place.anchor);
}

std::size_t ChangedSpace::memory_bytes() const {
  return (gone_.capacity() + swept_.capacity()) * sizeof(VoxelMap::Gone) + swept_voxels_.memory_bytes();
}

}  // namespace lcmslam
