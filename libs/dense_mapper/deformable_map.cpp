#include <lcmslam/dense_mapper/deformable_map.hpp>

#include <stdexcept>

#include <lcmslam/dense_mapper/by_node.hpp>

namespace lcmslam {
namespace {

constexpr double restored_around = 3;     // m
constexpr std::size_t asked_points = 50;  // of a keyframe
constexpr float found_within = 0.1f;      // m

}  // namespace

DeformableMap::DeformableMap(const DenseMapperSettings& settings)
    : settings_(settings), map_(std::make_unique<VoxelMap>(settings.map)) {}

std::size_t DeformableMap::memory_bytes() const {
  std::size_t bytes = map_->memory_bytes();
  for (const Insertion& insertion : waiting_) bytes += lcmslam::memory_bytes(insertion.cloud);
  return bytes;
}

void DeformableMap::insert(Cloud cloud_in_world, const Eigen::Isometry3d& T_world_view, int node) {
  if (deforming())
    waiting_.push_back({std::move(cloud_in_world), T_world_view, node});
  else
    map_->insert(cloud_in_world, T_world_view, node);
}

void DeformableMap::restore(const std::vector<KeyframeStore::Keyframe>& keyframes,
                            const Eigen::Isometry3d& T_world_camera) {
  if (!map_->has_forgotten() || deforming()) return;  // what waits cannot be found, and would come again
  for (const auto& keyframe : keyframes) {
    const std::size_t size = keyframe.cloud.size();
    if (distance_between(keyframe.T_world_camera, T_world_camera) > restored_around || size == 0) continue;
    std::size_t known = 0, asked = 0;
    TargetPoint found;
    const Eigen::Isometry3f T = keyframe.T_world_camera.cast<float>();
    for (std::size_t i = 0; i < size; i += 1 + size / asked_points, ++asked)
      known += map_->find(T * keyframe.cloud.points[i], found_within, found) ? 1 : 0;
    if (10 * known >= 9 * asked) continue;
    Cloud cloud = geometry_of(keyframe.cloud, keyframe.T_world_camera);
    if (map_->has_intensities()) cloud.intensities = intensities_of(keyframe.cloud);
    cloud =
        kept_points(cloud, [&](std::size_t i) { return !map_->find(cloud.points[i], found_within, found); });
    insert(settings_.voxel_size > 0 ? voxel_filtered(cloud, settings_.voxel_size) : cloud, T_world_camera,
           keyframe.node);
  }
}

std::vector<VoxelMap::Gone> DeformableMap::look_through(const FreeSpaceView& view,
                                                        const Eigen::Isometry3d& T_world_camera,
                                                        const FreeSpaceSettings& settings, std::int32_t turn,
                                                        int first_node) {
  if (deforming()) throw std::logic_error("deformable map: looked through while it is being deformed");
  return map_->look_through(view, T_world_camera, settings, turn, first_node);
}

void DeformableMap::begin_deforming(Correction correction, Utime now) {
  if (deforming()) throw std::logic_error("deformable map: it is being deformed already");
  correction_ = std::move(correction);
  const double seconds =
      settings_.deform_time + settings_.deform_time_per_surfel * static_cast<double>(map_->size());
  due_ = now + static_cast<Utime>(1e6 * seconds);
  deforming_ = std::async(std::launch::async, [map = map_.get(), &by = correction_] {
    return std::make_unique<VoxelMap>(map->deformed(by));
  });
}

const DeformableMap::Correction& DeformableMap::finish_deforming() {
  map_ = deforming_.get();
  for (const Insertion& insertion : waiting_) {
    const Eigen::Isometry3d& T = of_node(correction_, insertion.node);
    map_->insert(transformed(insertion.cloud, T), T * insertion.T_world_view, insertion.node);
  }
  waiting_.clear();
  return correction_;
}

const DeformableMap::Correction& DeformableMap::deform(Correction correction) {
  if (deforming()) throw std::logic_error("deformable map: it is being deformed already");
  correction_ = std::move(correction);
  map_ = std::make_unique<VoxelMap>(map_->deformed(correction_));
  return correction_;
}

void DeformableMap::renumber(const std::vector<int>& index) {
  if (deforming()) throw std::logic_error("deformable map: renumbered while it is being deformed");
  map_->renumber_anchors(index);
}

}  // namespace lcmslam
