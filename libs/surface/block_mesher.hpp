#pragma once
// The surface of one block: marching cubes over its voxels and the first ones of the blocks that follow.

#include <functional>

#include <lcmslam/surface/mesh.hpp>
#include <lcmslam/surface/voxel_blocks.hpp>

namespace lcmslam {

/// A mesh that knows on which edge of the voxel grid each vertex stands, so that pieces can be joined.
struct MeshPiece {
  Mesh mesh;
  std::vector<std::uint64_t> edges;  ///< of each vertex: voxel_key of the edge's middle in half voxels
};

/// Cells whose corners all have `min_weight`, except those with `skipped(centre in m)`. A cell is also left
/// out where neighbouring distances differ by more than a surface can make them: behind the outline of
/// something in front, free space and shade meet without a wall between them.
MeshPiece mesh_block(const VoxelBlocks& blocks, std::size_t block, float min_weight,
                     const std::function<bool(const Eigen::Vector3f&)>& skipped = nullptr);

}  // namespace lcmslam
