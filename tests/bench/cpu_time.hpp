#pragma once
// What benchmarks measure with, on a machine that others use too.

#include <time.h>
#include <algorithm>
#include <vector>

namespace lcmslam {

/// CPU time of this thread, or of the whole process with CLOCK_PROCESS_CPUTIME_ID.
inline double cpu_milliseconds(clockid_t clock = CLOCK_THREAD_CPUTIME_ID) {
  timespec time{};
  clock_gettime(clock, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// The value of the nearest rank; share 0.5 is the median.
inline double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

}  // namespace lcmslam
