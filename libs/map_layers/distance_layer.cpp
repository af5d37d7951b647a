#include <lcmslam/map_layers/distance_layer.hpp>

#include <algorithm>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr int slab = block_side * block_side;  // cells that share a place on the slowest axis

// All pairs of slabs of two blocks, `first` slabs from one to the other; not those whose nearest source is no
// nearer to any target than what the target has already.
LCMSLAM_VECTORISED(approach, (const std::int16_t* from, int first, int reach, std::int16_t* to),
                   (from, first, reach, to)) {
  std::int16_t least[block_side];  // of each slab
  for (int s = 0; s < block_side; ++s) {
    std::int16_t nearest = far_squared;
    for (int i = 0; i < slab; ++i) nearest = std::min(nearest, from[s * slab + i]);
    least[s] = nearest;
  }
  for (int t = 0; t < block_side; ++t) {
    std::int16_t* target = to + t * slab;
    std::int16_t most = 0;
    for (int i = 0; i < slab; ++i) most = std::max(most, target[i]);
    for (int s = 0; s < block_side; ++s) {
      const int distance = first + s - t;
      if (distance > reach || -distance > reach) continue;
      const auto square = static_cast<std::int16_t>(distance * distance);
      if (least[s] + square >= most) continue;
      const std::int16_t* source = from + s * slab;
      for (int i = 0; i < slab; ++i) {
        const auto sum = static_cast<std::int16_t>(source[i] + square);
        target[i] = std::min(target[i], sum);
      }
    }
  }
}

}  // namespace

bool transform_block(const DistanceLayer& from, const Eigen::Vector3i& block, int axis, int reach,
                     SquaredDistances& to) {
  SquaredDistances nearest;
  nearest.fill(far_squared);
  bool any = false;
  const int blocks = (reach + block_side - 1) / block_side;
  for (int n = 0; n <= 2 * blocks; ++n) {
    const int k = n % 2 == 0 ? n / 2 : -(n + 1) / 2;  // from near to far: the far ones mostly bring nothing
    const auto* source = from.find(block + k * Eigen::Vector3i::Unit(axis));
    if (source == nullptr) continue;
    approach((*source)->data(), block_side * k, reach, nearest.data());
    any = true;
  }
  if (!any) return false;
  const int limit = reach * reach;
  bool near = false;
  for (std::size_t t = 0; t < block_side; ++t)
    for (std::size_t i = 0; i < slab; ++i) {
      const std::int16_t square = nearest[t * slab + i];
      to[t + block_side * i] = square <= limit ? square : far_squared;
      near = near || square <= limit;
    }
  return near;
}

}  // namespace lcmslam
