#pragma once
// The mesh of a growing surface: what changed is meshed anew, the rest stays.

#include <map>

#include <lcmslam/surface/block_mesher.hpp>
#include <lcmslam/surface/surface_settings.hpp>

namespace lcmslam {

class SurfaceMesh {
 public:
  explicit SurfaceMesh(const SurfaceSettings& settings);

  /// Meshes the blocks that changed since the last call, and those beside them. The coarse surface shows
  /// where there is no fine one.
  void update(const VoxelBlocks& fine, const VoxelBlocks& coarse);

  /// The whole mesh; neighbouring pieces share their vertices. The same whatever the number of updates on the
  /// way.
  Mesh joined() const;

  std::size_t memory_bytes() const;

 private:
  struct Piece {
    Eigen::Vector3i at;
    MeshPiece mesh;
  };
  using Pieces = std::map<std::uint64_t, Piece>;  // by voxel_key of the block

  void update_level(const VoxelBlocks& blocks, const std::vector<bool>& due, bool is_coarse,
                    Pieces& pieces) const;
  /// Whether fine pieces show the surface here already.
  bool is_fine(const VoxelBlocks& fine, float reach, const Eigen::Vector3f& point) const;

  float min_weight_;
  std::int64_t seen_ = 0;  // fusion
  Pieces fine_, coarse_;
  const VoxelBlocks* fine_blocks_ = nullptr;  // during update()
};

}  // namespace lcmslam
