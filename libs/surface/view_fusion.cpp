#include <lcmslam/surface/view_fusion.hpp>

#include <algorithm>
#include <limits>

#include <lcmslam/surface/block_update.hpp>
#include <lcmslam/surface/pixel_blocks.hpp>
#include <lcmslam/surface/view_reach.hpp>

namespace lcmslam {
namespace {

constexpr float half_shell = 2;  // voxels before and behind a surface that get blocks: what meshes look at

/// Where several pixels fit into the shell one of them asks.
class PixelStride {
 public:
  /// `depth`: m, at which a pixel is as large as the shell.
  explicit PixelStride(float depth) : depth_(depth) {}
  int at(float z) const { return z < depth_ / 8 ? 8 : z < depth_ / 4 ? 4 : z < depth_ / 2 ? 2 : 1; }

 private:
  float depth_;
};

float farthest_in_row(const SurfaceView& view, int v) {
  const float* tiles = view.farthest[v / SurfaceView::tile];
  return *std::max_element(tiles, tiles + view.farthest.cols);
}

/// Blocks in the order in which pixels ask for them.
void make_blocks(const SurfaceView& view, const Eigen::Isometry3f& T_map_depth, float range,
                 std::int64_t fusion, VoxelBlocks& blocks) {
  const float shell = half_shell * blocks.voxel_size();
  const PixelStride stride(shell * static_cast<float>(view.camera.fx));
  PixelBlocks wanted(T_map_depth, blocks, shell, view.camera.width);
  Eigen::Vector3i last[PixelBlocks::samples];
  for (Eigen::Vector3i& at : last) at.setConstant(std::numeric_limits<int>::max());
  for (int v = 0; v < view.camera.height; ++v) {
    const int least = stride.at(farthest_in_row(view, v));
    if (v % least != 0) continue;
    wanted.find(view.points.ptr<float>(v), view.normals.ptr<float>(v));
    const float* depth = view.depth.data() + view.at(v, 0);
    for (int u = 0; u < view.camera.width; u += least) {
      const float z = depth[u];
      if (!(z > 0 && z <= range) || ((u | v) & (stride.at(z) - 1)) != 0) continue;
      for (int k = 0; k < PixelBlocks::samples; ++k) {
        if (!wanted.exists(k, u)) continue;
        const Eigen::Vector3i at = wanted.block(k, u);
        if (at == last[k]) continue;
        last[k] = at;
        blocks.find_or_make(at, fusion);
      }
    }
  }
}

void look_into_blocks(const SurfaceView& view, const Eigen::Isometry3f& T_map_depth,
                      const SurfaceSettings& settings, bool taken_out, std::int64_t until,
                      std::int64_t fusion, VoxelBlocks& blocks) {
  const Eigen::Isometry3f T_depth_map = T_map_depth.inverse();
  const float size = blocks.voxel_size();
  const ViewReach reach(view, T_depth_map.linear(), blocks);
  LookSettings look_settings;
  look_settings.truncation = blocks.truncation();
  look_settings.colour_reach = 2 * size;
  look_settings.most_weight = VoxelBlock::full_look * static_cast<float>(settings.max_looks);
  look_settings.taken_out = taken_out;
  BlockPlace place;
  for (int axis = 0; axis < 3; ++axis) place.step[axis] = size * T_depth_map.linear().col(axis);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    VoxelBlocks::Entry& entry = blocks[i];
    if (entry.born > until) continue;
    if (!reach.holds(T_depth_map * blocks.centre(entry))) continue;
    place.first = T_depth_map * (size * VoxelBlock::side * entry.at.cast<float>());
    if (update_block(view, place, look_settings, *entry.block)) entry.changed = fusion;
  }
}

}  // namespace

void fuse_view(const SurfaceView& view, const Eigen::Isometry3d& T_map_depth, const SurfaceSettings& settings,
               double range, std::int64_t fusion, VoxelBlocks& blocks) {
  const Eigen::Isometry3f T = T_map_depth.cast<float>();
  make_blocks(view, T, static_cast<float>(range), fusion, blocks);
  look_into_blocks(view, T, settings, false, fusion, fusion, blocks);
}

void take_out_view(const SurfaceView& view, const Eigen::Isometry3d& T_map_depth,
                   const SurfaceSettings& settings, std::int64_t fused, std::int64_t fusion,
                   VoxelBlocks& blocks) {
  look_into_blocks(view, T_map_depth.cast<float>(), settings, true, fused, fusion, blocks);
}

}  // namespace lcmslam
