#pragma once
// The mesh of a growing surface: what changed is meshed anew, the rest stays.

#include <map>
#include <vector>

#include <lcmslam/surface/block_mesher.hpp>
#include <lcmslam/surface/surface_settings.hpp>

namespace lcmslam {

/// A cube of some blocks of one level, and when it last changed.
struct MeshCube {
  bool is_coarse = false;
  Eigen::Vector3i at{0, 0, 0};  ///< of its corner of least x, y, z, in cubes
  std::int64_t changed = 0;     ///< the higher, the later
};

class SurfaceMesh {
 public:
  explicit SurfaceMesh(const SurfaceSettings& settings);

  /// Meshes the blocks that changed since the last call, and those beside them. The coarse surface shows
  /// where there is no fine one.
  void update(const VoxelBlocks& fine, const VoxelBlocks& coarse);

  /// The whole mesh; neighbouring pieces share their vertices. The same whatever the number of updates on the
  /// way.
  Mesh joined() const;

  /// For those who follow the mesh: the cubes that changed after `changed` (0: all), also such as are empty
  /// now.
  std::vector<MeshCube> cubes(std::int64_t changed) const;
  /// What is in a cube. Beside its sides vertices stand twice, once for each cube.
  Mesh joined(const MeshCube& cube) const;
  static constexpr int blocks_per_cube = 8;  ///< along each side

  std::size_t memory_bytes() const;

 private:
  struct Piece {
    Eigen::Vector3i at;
    MeshPiece mesh;
  };
  using Pieces = std::map<std::uint64_t, Piece>;  // by voxel_key of the block

  void update_level(const VoxelBlocks& blocks, const std::vector<bool>& due, bool is_coarse, Pieces& pieces);
  void note_change(bool is_coarse, const Eigen::Vector3i& block);
  /// Whether fine pieces show the surface here already.
  bool is_fine(const VoxelBlocks& fine, float reach, const Eigen::Vector3f& point) const;

  float min_weight_;
  std::int64_t seen_ = 0;  // fusion
  Pieces fine_, coarse_;
  std::int64_t updates_ = 0;
  std::map<std::pair<bool, std::uint64_t>, MeshCube> cubes_;  // by level and voxel_key
  const VoxelBlocks* fine_blocks_ = nullptr;                  // during update()
};

}  // namespace lcmslam
