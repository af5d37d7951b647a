#pragma once
// The voxel map and its deforming by the graph. Deforming takes long, so it runs in a thread of its own and
// is taken over at a fixed message time: the same log gives the same map however fast the machine is. Until
// then the map that is read stays as it is, and what should be inserted waits.
//
//   map.begin_deforming(correction, now);
//   if (map.is_due(later)) const auto& correction = map.finish_deforming();  // for all else that must move

#include <future>
#include <memory>
#include <vector>

#include <lcmslam/dense_mapper/keyframe_store.hpp>
#include <lcmslam/dense_mapper/voxel_map.hpp>

namespace lcmslam {

class DeformableMap {
 public:
  using Correction = KeyframeGraph::Correction;

  /// Reads the settings map, voxel_size and bend_*.
  explicit DeformableMap(const DenseMapperSettings& settings);
  DeformableMap(const DeformableMap&) = delete;  // a thread reads it
  DeformableMap& operator=(const DeformableMap&) = delete;

  /// Valid until a deformation ends.
  const VoxelMap& voxels() const { return *map_; }
  std::size_t memory_bytes() const;

  /// A cloud in the world, seen from `T_world_view`, which moves with a node of the graph.
  void insert(Cloud cloud_in_world, const Eigen::Isometry3d& T_world_view, int node);
  /// The map is bounded and forgets what is far; keyframes around the camera give back what they know of it.
  void restore(const std::vector<KeyframeStore::Keyframe>& keyframes,
               const Eigen::Isometry3d& T_world_camera);
  /// Surfels that the view sees through (VoxelMap::look_through). Not while the map is being deformed.
  std::vector<VoxelMap::Gone> look_through(const FreeSpaceView& view, const Eigen::Isometry3d& T_world_camera,
                                           const FreeSpaceSettings& settings, std::int32_t turn,
                                           int first_node = 0);

  bool deforming() const { return deforming_.valid(); }
  void begin_deforming(Correction correction, Utime now);
  bool is_due(Utime now) const { return deforming() && now >= due_; }
  /// Waits for the thread; what waited is inserted where it has moved to. Returns the correction.
  const Correction& finish_deforming();
  /// At once.
  const Correction& deform(Correction correction);

  /// Surfels of node i belong to index[i] now. Not while the map is being deformed.
  void renumber(const std::vector<int>& index);

 private:
  struct Insertion {
    Cloud cloud;
    Eigen::Isometry3d T_world_view;
    int node = 0;
  };

  DenseMapperSettings settings_;
  std::unique_ptr<VoxelMap> map_;
  std::vector<Insertion> waiting_;
  Correction correction_;
  Utime due_ = 0;
  std::future<std::unique_ptr<VoxelMap>> deforming_;  // the last member: it ends before what it reads goes
};

}  // namespace lcmslam
