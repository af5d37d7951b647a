#include "tools/launch/limits.hpp"

#include <sched.h>
#include <sys/resource.h>

namespace lcmslam {

const char* apply(const ProcessLimits& limits) {
  if (!limits.cpus.empty()) {
    cpu_set_t set;
    CPU_ZERO(&set);
    for (const int cpu : limits.cpus)
      if (cpu >= 0 && cpu < CPU_SETSIZE) CPU_SET(static_cast<unsigned>(cpu), &set);
    if (sched_setaffinity(0, sizeof set, &set) != 0) return "cpus: the machine has none of these cores";
  }
  if (limits.nice != 0 && setpriority(PRIO_PROCESS, 0, limits.nice) != 0)
    return "nice: only root may go below 0";
  if (limits.memory > 0) {
    // Private writable memory. RLIMIT_AS would count what is mapped from files and libraries too, and
    // RLIMIT_RSS does nothing.
    const rlimit most{limits.memory, limits.memory};
    if (setrlimit(RLIMIT_DATA, &most) != 0) return "memory: the limit cannot be set";
  }
  return nullptr;
}

}  // namespace lcmslam
