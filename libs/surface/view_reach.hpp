#pragma once
// Which blocks a view can change: those before the surfaces that it measured, or behind them within the
// truncation.

#include <lcmslam/surface/surface_view.hpp>
#include <lcmslam/surface/voxel_blocks.hpp>

namespace lcmslam {

class ViewReach {
 public:
  /// `R_depth_map`: rotation of the blocks into the depth camera's frame. The view must live as long.
  ViewReach(const SurfaceView& view, const Eigen::Matrix3f& R_depth_map, const VoxelBlocks& blocks);

  /// Of a block around `centre` (m, depth camera's frame); never false where a voxel would change.
  bool holds(const Eigen::Vector3f& centre) const;

 private:
  bool holds_tiles(float left, float right, float top, float bottom, float nearest) const;

  const SurfaceView& view_;
  Eigen::Vector3f half_;  // m, from a block's centre to its outermost voxels
  float truncation_;
};

}  // namespace lcmslam
