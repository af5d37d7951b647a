#pragma once
// Calls of operator new in this program so far, on this thread. For "no allocation in steady state".

namespace lcmslam {

long heap_allocations();

}  // namespace lcmslam
