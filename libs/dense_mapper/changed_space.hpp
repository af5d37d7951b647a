#pragma once
// What moved away leaves the map and then the keyframes' clouds. Each frame looks through the map; the places
// of surfels that went are collected, and once they are many enough, a sweep cleans the keyframes that may
// have seen them: one a frame, so that no frame takes long.

#include <vector>

#include <lcmslam/cloud/voxel_index.hpp>
#include <lcmslam/dense_mapper/deformable_map.hpp>
#include <lcmslam/dense_mapper/keyframe_store.hpp>

namespace lcmslam {

class ChangedSpace {
 public:
  /// Reads the settings free_space, filter and map. The thesis's variants forget nothing: with them it rests.
  explicit ChangedSpace(const DenseMapperSettings& settings);

  /// A frame whose pose among the nodes from `first_node` on is certain; `cloud` in the camera frame.
  void look_through(const Cloud& cloud, const Eigen::Isometry3d& T_world_camera, DeformableMap& map,
                    KeyframeStore& keyframes, int first_node = 0);
  /// All that is left to clean, once no keyframe waits to be merged.
  void finish(const VoxelMap& map, KeyframeStore& keyframes);

  /// Places move with the nodes that their surfels belonged to.
  void deform(const KeyframeGraph::Correction& correction);
  void renumber(const KeyframeGraph::Thinned& thinned);

  bool sweeping() const { return !swept_.empty(); }
  std::size_t memory_bytes() const;

 private:
  void begin_sweep(KeyframeStore& keyframes);
  void index();
  void clean_next(const VoxelMap& map, KeyframeStore& keyframes);
  void clean(std::size_t i, const VoxelMap& map, KeyframeStore& keyframes) const;

  bool enabled_;
  FreeSpaceSettings settings_;
  double seen_within_;  // m from its camera that a keyframe has points
  float voxel_size_;    // m, of the map
  float inverse_size_;  // 1/m
  std::int32_t looks_ = 0;
  std::vector<VoxelMap::Gone> gone_, swept_;  // collected; being swept (empty: no sweep)
  VoxelIndex swept_voxels_;                   // the map's voxels that swept_ touches
  Eigen::AlignedBox3f swept_box_;
};

}  // namespace lcmslam
