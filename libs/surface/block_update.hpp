#pragma once
// One look at one block: the running mean of each voxel's distance and colour (Curless and Levoy 1996).

#include <Eigen/Core>

#include <lcmslam/surface/surface_view.hpp>
#include <lcmslam/surface/voxel_blocks.hpp>

namespace lcmslam {

/// A block's voxels in the depth camera's frame: first + x step[0] + y step[1] + z step[2], m.
struct BlockPlace {
  Eigen::Vector3f first;
  Eigen::Vector3f step[3];
};

struct LookSettings {
  float truncation = 0;    ///< m
  float colour_reach = 0;  ///< m from the surface to which voxels are coloured
  float most_weight = 0;   ///< in units of VoxelBlock::weight
  bool taken_out = false;  ///< the look is taken out again, as exactly as numbers are kept
};

/// True when some voxel changed. Lens distortion of up to eight coefficients is applied.
bool update_block(const SurfaceView& view, const BlockPlace& place, const LookSettings& settings,
                  VoxelBlock& block);

}  // namespace lcmslam
