#pragma once
// One pass of the exact Euclidean distance transform (Saito and Toriwaki 1994; Felzenszwalb and Huttenlocher
// 2012, distances along one axis after the other), for blocks of a sparse grid:
//
//   to(cell) = min over s of from(cell + s e) + s^2,   |s| <= reach,
//
// with e the slowest axis of `from`. `to` is turned so that its slowest axis is the next one.

#include <array>
#include <cstdint>
#include <memory>

#include <lcmslam/map_layers/block_table.hpp>

namespace lcmslam {

/// Squared distances in cells; `far_squared` where nothing is near.
using SquaredDistances = std::array<std::int16_t, block_cells>;
constexpr std::int16_t far_squared = 20000;
/// Cells: reach^2 + far_squared fits into 16 bits.
constexpr int greatest_reach = 100;
constexpr int least_reach = 2;  // below it collision questions could not tell a body that fits

using DistanceLayer = BlockTable<std::unique_ptr<SquaredDistances>>;

/// `to` for one block. `axis`: the one of the map that is slowest in `from`. False when all of it is far.
bool transform_block(const DistanceLayer& from, const Eigen::Vector3i& block, int axis, int reach,
                     SquaredDistances& to);

}  // namespace lcmslam
