#pragma once
// Which blocks the pixels of a row ask for: those before, at and behind what each measured.

#include <cstdlib>
#include <vector>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/surface/voxel_blocks.hpp>

namespace lcmslam {

/// From m in the depth camera's frame to blocks of the map, half a voxel on.
struct BlockGrid {
  float R[9], t[3];
  float shell;  ///< m
};

class PixelBlocks {
 public:
  static constexpr int samples = 3;          ///< before, at, behind
  static constexpr int outside = 1'000'000;  ///< blocks from the origin; voxel_key() packs up to 2^20

  /// `shell`: m from the surface to the sample before it and to the one behind.
  PixelBlocks(const Eigen::Isometry3f& T_map_depth, const VoxelBlocks& blocks, float shell, int columns);

  /// `points` (m) and `normals` in the depth camera's frame, three numbers a pixel.
  void find(const float* points, const float* normals);

  /// False where the point or the normal is NaN or lies farther than a map reaches.
  bool exists(int sample, int u) const {
    const auto inside = [&](int axis) { return std::abs(at(sample, axis, u)) < outside; };
    return inside(0) && inside(1) && inside(2);
  }
  Eigen::Vector3i block(int sample, int u) const {
    return {at(sample, 0, u), at(sample, 1, u), at(sample, 2, u)};
  }

 private:
  std::int32_t at(int sample, int axis, int u) const {
    return at_[static_cast<std::size_t>((3 * sample + axis) * columns_ + u)];
  }

  BlockGrid grid_;
  int columns_;
  std::vector<std::int32_t> at_;  // columns after columns
};

}  // namespace lcmslam
