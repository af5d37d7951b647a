#include <lcmslam/map_layers/distance_layer.hpp>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

// More than any reach's, and fits into 16 bits with far_squared.
constexpr std::int16_t beyond_squared = 12000;
static_assert(beyond_squared > greatest_reach * greatest_reach && beyond_squared + far_squared < 32768);

constexpr int slab = block_side * block_side;  // cells that share a place on the slowest axis

using Sixteen = std::int16_t __attribute__((vector_size(32)));

LCMSLAM_VECTORISED(find_nearest, (const std::int16_t* cells, std::int16_t* nearest), (cells, nearest)) {
  std::int16_t least = far_squared;
  for (int i = 0; i < block_cells; ++i) least = std::min(least, cells[i]);
  *nearest = least;
}

LCMSLAM_VECTORISED(find_farthest, (const std::int16_t* cells, std::int16_t* farthest), (cells, farthest)) {
  std::int16_t most = 0;
  for (int i = 0; i < block_cells; ++i) most = std::max(most, cells[i]);
  *farthest = most;
}

// Whether no cell of a block is nearer to one of another block, so many cells on, than what that has already.
bool brings_nothing(const SquaredDistances& from, int apart, const SquaredDistances& to) {
  const int gap = apart - (block_side - 1);
  if (gap <= block_side) return false;  // not worth a look
  std::int16_t least = 0, most = 0;
  find_farthest(to.data(), &most);
  if (gap * gap >= most) return true;
  find_nearest(from.data(), &least);
  return least + gap * gap >= most;
}

// All pairs of slabs of two blocks, s of one and t of the other: squares[7 + s - t] apart.
LCMSLAM_VECTORISED(approach, (const std::int16_t* from, const std::int16_t* squares, std::int16_t* to),
                   (from, squares, to)) {
  for (int i = 0; i < slab; i += 16) {
    Sixteen source[block_side];
    for (int s = 0; s < block_side; ++s) std::memcpy(source + s, from + s * slab + i, sizeof(Sixteen));
    for (int t = 0; t < block_side; ++t) {
      Sixteen nearest;
      std::memcpy(&nearest, to + t * slab + i, sizeof(Sixteen));
      for (int s = 0; s < block_side; ++s) {
        const Sixteen sum = source[s] + squares[block_side - 1 + s - t];
        nearest = sum < nearest ? sum : nearest;
      }
      std::memcpy(to + t * slab + i, &nearest, sizeof(Sixteen));
    }
  }
}

using Eight = std::int16_t __attribute__((vector_size(16)));

// Eight rows become eight columns.
void turn(Eight (&m)[8]) {
  Eight of_pairs[8], of_fours[8];
  for (int i = 0; i < 4; ++i) {
    of_pairs[2 * i] = __builtin_shufflevector(m[2 * i], m[2 * i + 1], 0, 8, 1, 9, 2, 10, 3, 11);
    of_pairs[2 * i + 1] = __builtin_shufflevector(m[2 * i], m[2 * i + 1], 4, 12, 5, 13, 6, 14, 7, 15);
  }
  for (int i = 0; i < 8; i += 4)
    for (int half = 0; half < 2; ++half) {
      const Eight left = of_pairs[i + half], right = of_pairs[i + 2 + half];
      of_fours[i + 2 * half] = __builtin_shufflevector(left, right, 0, 1, 8, 9, 2, 3, 10, 11);
      of_fours[i + 2 * half + 1] = __builtin_shufflevector(left, right, 4, 5, 12, 13, 6, 7, 14, 15);
    }
  for (int i = 0; i < 4; ++i) {
    m[2 * i] = __builtin_shufflevector(of_fours[i], of_fours[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    m[2 * i + 1] = __builtin_shufflevector(of_fours[i], of_fours[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

// What is beyond the limit is far. Returns whether anything is not.
bool limit_and_turn(const SquaredDistances& nearest, int limit, SquaredDistances& to) {
  static_assert(block_side == 8 && sizeof(Eight) == 8 * sizeof(std::int16_t));
  const Eight most = Eight{} + static_cast<std::int16_t>(limit), far = Eight{} + far_squared;
  Eight near = {};
  for (int first = 0; first < slab; first += 8) {
    Eight rows[8];
    for (int t = 0; t < 8; ++t) {
      std::memcpy(rows + t, nearest.data() + t * slab + first, sizeof(Eight));
      const Eight is_near = rows[t] <= most;
      near |= is_near;
      rows[t] = (rows[t] & is_near) | (far & ~is_near);
    }
    turn(rows);
    std::memcpy(to.data() + 8 * first, rows, sizeof rows);
  }
  for (int i = 0; i < 8; ++i)
    if (near[i] != 0) return true;
  return false;
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
    any = true;
    if (brings_nothing(**source, block_side * std::abs(k), nearest)) continue;
    std::int16_t squares[2 * block_side - 1];
    for (int i = 0; i < 2 * block_side - 1; ++i) {
      const int distance = std::abs(block_side * k + i - (block_side - 1));
      squares[i] = distance > reach ? beyond_squared : static_cast<std::int16_t>(distance * distance);
    }
    approach((*source)->data(), squares, nearest.data());
  }
  if (!any) return false;
  return limit_and_turn(nearest, reach * reach, to);
}

}  // namespace lcmslam
