#pragma once
// Squared distances of byte descriptors by the instructions that multiply and sum four bytes at a time
// (AVX512-VNNI): the same integers as descriptor_distance.hpp's, in half the time.

#include <lcmslam/features/descriptor_distance.hpp>

namespace lcmslam {

/// Null where the processor lacks the instructions, or they may not be used.
DistanceFunction dot_product_distances();
LoneDistanceFunction lone_dot_product_distances();

/// For tests: whether they may be used from now on, in all threads. Returns what was so before.
bool allow_dot_products(bool allowed);

}  // namespace lcmslam
