#pragma once
// Squared distances of byte descriptors, four queries against many at once: the one inner loop of all
// matching. |q - t|^2 = |q|^2 + |t|^2 - 2 q.t in integers, so every instruction set gives the same bits.

#include <cstdint>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {

/// Four integers side by side, one for each query of a group.
using Int4 = std::int32_t __attribute__((vector_size(16)));

/// A descriptor widened to 16 bits, and its squared norm.
struct alignas(32) WideDescriptor {
  std::int16_t values[64];
  std::int32_t norm2 = 0;

  void assign(const Descriptor& descriptor);
};

/// Squared norm of 64 bytes.
std::int32_t squared_norm(const Descriptor& descriptor);

/// Writes distances[t][q] = |queries[q] - targets[t]|^2 for t = 0..count-1, q = 0..3; norms2[t] is
/// |targets[t]|^2. A query may stand several times, where there are less than four.
using DistanceFunction = void (*)(const WideDescriptor* const queries[4], const Descriptor* targets,
                                  const std::int32_t* norms2, int count, Int4* distances);

/// Throws std::invalid_argument when the processor lacks the instructions.
DistanceFunction distance_function(InstructionSet set = best_instruction_set());

/// Writes distances[t] = |query - targets[t]|^2 for t = 0..count-1: for a query that comes alone.
using LoneDistanceFunction = void (*)(const WideDescriptor& query, const Descriptor* targets,
                                      const std::int32_t* norms2, int count, std::int32_t* distances);

/// Throws std::invalid_argument when the processor lacks the instructions.
LoneDistanceFunction lone_distance_function(InstructionSet set = best_instruction_set());

/// Whether any of the four comparisons (0 or -1 each) holds.
inline bool any(Int4 comparison) {
  using Long2 = std::int64_t __attribute__((vector_size(16)));
  const Long2 halves = (Long2)comparison;
  return (halves[0] | halves[1]) != 0;
}

}  // namespace lcmslam
