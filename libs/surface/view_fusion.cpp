#include <lcmslam/surface/view_fusion.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/surface/block_update.hpp>

namespace lcmslam {
namespace {

constexpr float half_shell = 2;  // voxels before and behind a surface that get blocks: what meshes look at

/// Blocks in the order in which pixels ask for them.
void make_blocks(const SurfaceView& view, const Eigen::Isometry3f& T_map_depth, float range,
                 std::int64_t fusion, VoxelBlocks& blocks) {
  const float shell = half_shell * blocks.voxel_size(), inverse_size = 1 / blocks.block_size();
  Eigen::Vector3i last[3];
  for (Eigen::Vector3i& at : last) at.setConstant(std::numeric_limits<int>::max());
  const auto fx = static_cast<float>(view.camera.fx);
  for (int v = 0; v < view.camera.height; ++v) {
    for (int u = 0; u < view.camera.width; ++u) {
      const std::size_t i = view.at(v, u);
      const float z = view.depth[i];
      // Every second pixel, where pixels are smaller than half a voxel anyway.
      if (!(z > 0 && z <= range) || ((u | v) & 1 && z < fx * shell / 2)) continue;
      const Eigen::Vector3f point = view.point(v, u);
      const Eigen::Vector3f in_map = T_map_depth * point,
                            way = shell * (T_map_depth.linear() * view.normal(i));
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3f sample = in_map + static_cast<float>(k - 1) * way;
        const Eigen::Vector3i at = blocks.block_of(sample);
        if (at == last[k]) continue;
        last[k] = at;
        if (voxel_exists(sample, inverse_size)) blocks.find_or_make(at, fusion);
      }
    }
  }
}

/// The farthest depth around where a sphere is seen; less than any where it is not seen.
float farthest_around(const SurfaceView& view, const Eigen::Vector3f& centre, float radius) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  if (centre.z() < radius) return centre.z() > -radius && centre.norm() < 2 * radius ? infinity : -infinity;
  // Lens distortion moves a pixel by less than this share of its distance from the middle.
  constexpr float distorted = 0.15f;
  const CameraModel& camera = view.camera;
  const float nearest = std::max(centre.z() - radius, 0.05f);
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const float du = fx * centre.x() / centre.z(), dv = fy * centre.y() / centre.z();
  const float bend = camera.distortion.empty() ? 0.0f : distorted * (std::abs(du) + std::abs(dv));
  const float reach = fx * radius / nearest * (1 + (std::abs(du) + std::abs(dv)) / fx) + bend + 1;
  const float u = du + static_cast<float>(camera.cx), v = dv + static_cast<float>(camera.cy);
  const auto tile_of = [](float pixel, int tiles) {
    return static_cast<int>(
        std::floor(std::clamp(pixel / SurfaceView::tile, -1.0f, static_cast<float>(tiles))));
  };
  const int left = std::max(tile_of(u - reach, view.farthest.cols), 0),
            right = std::min(tile_of(u + reach, view.farthest.cols), view.farthest.cols - 1),
            top = std::max(tile_of(v - reach, view.farthest.rows), 0),
            bottom = std::min(tile_of(v + reach, view.farthest.rows), view.farthest.rows - 1);
  float farthest = 0;
  for (int row = top; row <= bottom; ++row)
    for (int column = left; column <= right; ++column)
      farthest = std::max(farthest, view.farthest(row, column));
  return farthest > 0 ? farthest : -infinity;
}

void look_into_blocks(const SurfaceView& view, const Eigen::Isometry3f& T_map_depth,
                      const SurfaceSettings& settings, bool taken_out, std::int64_t until,
                      std::int64_t fusion, VoxelBlocks& blocks) {
  const Eigen::Isometry3f T_depth_map = T_map_depth.inverse();
  const float size = blocks.voxel_size();
  const float radius = 0.5f * std::sqrt(3.0f) * blocks.block_size();
  // Along a slanted ray the truncation reaches farther.
  const float hidden = radius + blocks.truncation() / static_cast<float>(std::cos(settings.max_incidence));
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
    const Eigen::Vector3f centre = T_depth_map * blocks.centre(entry);
    if (farthest_around(view, centre, radius) < centre.z() - hidden) continue;
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
