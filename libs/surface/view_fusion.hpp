#pragma once
// One view into the blocks that it sees, or out of them again.

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/surface/surface_view.hpp>
#include <lcmslam/surface/voxel_blocks.hpp>

namespace lcmslam {

/// Makes blocks around what the view measured up to `range` (m along the optical axis), and looks at all that
/// stand before the measured surfaces or near them. `fusion` numbers fusions from 1 on and grows.
void fuse_view(const SurfaceView& view, const Eigen::Isometry3d& T_map_depth, const SurfaceSettings& settings,
               double range, std::int64_t fusion, VoxelBlocks& blocks);

/// Takes out what fuse_view() put in as fusion `fused`, in all blocks that were there then; they change at
/// `fusion`.
void take_out_view(const SurfaceView& view, const Eigen::Isometry3d& T_map_depth,
                   const SurfaceSettings& settings, std::int64_t fused, std::int64_t fusion,
                   VoxelBlocks& blocks);

}  // namespace lcmslam
