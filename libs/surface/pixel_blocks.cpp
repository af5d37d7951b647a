#include <lcmslam/surface/pixel_blocks.hpp>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr float outside = PixelBlocks::outside;

// std::floor is a call where the processor is not known. NaN becomes the least.
__attribute__((always_inline)) inline std::int32_t floored(float c) {
  const float above = c > -outside ? c : -outside;
  const float safe = above < outside ? above : outside;
  const int whole = static_cast<int>(safe);
  return whole - (static_cast<float>(whole) > safe ? 1 : 0);
}

LCMSLAM_VECTORISED(find_row,
                   (const float* points, const float* normals, int columns, const BlockGrid& grid,
                    std::int32_t* __restrict at),
                   (points, normals, columns, grid, at)) {
  const BlockGrid g = grid;
  std::int32_t* __restrict out[3 * PixelBlocks::samples];
  for (int row = 0; row < 3 * PixelBlocks::samples; ++row) out[row] = at + row * columns;
#pragma GCC ivdep  // the rows do not overlap
  for (int u = 0; u < columns; ++u) {
    const float x = points[3 * u], y = points[3 * u + 1], z = points[3 * u + 2];
    const float nx = normals[3 * u], ny = normals[3 * u + 1], nz = normals[3 * u + 2];
    for (int axis = 0; axis < 3; ++axis) {
      const float* R = g.R + 3 * axis;
      const float centre = R[0] * x + R[1] * y + R[2] * z + g.t[axis];
      const float way = g.shell * (R[0] * nx + R[1] * ny + R[2] * nz);
      out[axis][u] = floored(centre - way);
      out[3 + axis][u] = floored(centre);
      out[6 + axis][u] = floored(centre + way);
    }
  }
}

}  // namespace

PixelBlocks::PixelBlocks(const Eigen::Isometry3f& T_map_depth, const VoxelBlocks& blocks, float shell,
                         int columns)
    : columns_(columns), at_(static_cast<std::size_t>(3 * samples * columns)) {
  const float to_blocks = 1 / blocks.block_size();
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 3; ++k) grid_.R[3 * axis + k] = to_blocks * T_map_depth.linear()(axis, k);
    grid_.t[axis] = to_blocks * (T_map_depth.translation()[axis] + 0.5f * blocks.voxel_size());
  }
  grid_.shell = shell;
}

void PixelBlocks::find(const float* points, const float* normals) {
  find_row(points, normals, columns_, grid_, at_.data());
}

}  // namespace lcmslam
