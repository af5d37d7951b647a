#pragma once
// Whether a thread gets a processor when it wants one. Programs that take the processors make everything late
// before anything is lost; the kernel tells it at once.

#include <chrono>
#include <cstdint>
#include <deque>

#include <lcmslam/runtime/machine.hpp>

namespace lcmslam {

class ProcessorWatch {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// What the kernel has counted of the thread so far, some times a second.
  void look(const ThreadTime& so_far, Time now);

  /// For half a second it has waited longer for a processor than it ran.
  bool is_starved() const { return starved_; }
  /// How often that began.
  std::int64_t stretches() const { return stretches_; }

 private:
  struct Look {
    Time at;
    ThreadTime time;
  };
  std::deque<Look> looks_;  // of the last half second and the one before
  bool starved_ = false;
  std::int64_t stretches_ = 0;
};

}  // namespace lcmslam
