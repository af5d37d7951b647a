#pragma once
// Distance fields in closed form, and what a mesh must be.

#include <functional>
#include <map>
#include <utility>

#include <lcmslam/surface/mesh.hpp>
#include <lcmslam/surface/voxel_blocks.hpp>

namespace lcmslam::testing {

/// Blocks from `low` to `high` whose voxels all have the field's distance (m) from a surface.
inline VoxelBlocks blocks_of(const std::function<float(const Eigen::Vector3f&)>& field,
                             const Eigen::Vector3i& low, const Eigen::Vector3i& high,
                             std::int64_t fusion = 1) {
  VoxelBlocks blocks(0.01, 4);
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x) {
        const auto number = static_cast<std::size_t>(blocks.find_or_make({x, y, z}, fusion));
        VoxelBlock& block = *blocks[number].block;
        for (int i = 0; i < VoxelBlock::voxels; ++i) {
          const Eigen::Vector3i voxel =
              8 * Eigen::Vector3i(x, y, z) + Eigen::Vector3i(i % 8, i / 8 % 8, i / 64);
          const float d = field(blocks.voxel_size() * voxel.cast<float>()) / blocks.truncation();
          block.distance[i] =
              static_cast<std::int16_t>(VoxelBlock::full_distance * std::min(std::max(d, -1.0f), 1.0f));
          block.weight[i] = 640;
        }
      }
  return blocks;
}

/// Directed edges without one the other way: 0 for a mesh that encloses something.
inline int open_edges(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      ++edges[{t[k], t[(k + 1) % 3]}];
      --edges[{t[(k + 1) % 3], t[k]}];
    }
  int open = 0;
  for (const auto& edge : edges) open += edge.second > 0;
  return open;
}

}  // namespace lcmslam::testing
