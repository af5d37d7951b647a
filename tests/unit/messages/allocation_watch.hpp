#pragma once
// The largest single piece of memory that was asked for through operator new.

#include <cstddef>

namespace lcmslam::testing {

void forget_allocations();
std::size_t largest_allocation();  ///< bytes, on this thread since forget_allocations()

}  // namespace lcmslam::testing
