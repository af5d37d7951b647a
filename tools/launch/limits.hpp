#pragma once
// What a process may take of the machine.

#include <cstdint>
#include <vector>

namespace lcmslam {

struct ProcessLimits {
  std::vector<int> cpus;  ///< empty: all
  int nice = 0;
  std::uint64_t memory = 0;  ///< bytes of private memory, 0: no limit
};

/// Of the calling process, between fork and exec: only system calls. Gives what the kernel refused, in words;
/// null: nothing.
const char* apply(const ProcessLimits& limits);

}  // namespace lcmslam
