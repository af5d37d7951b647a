#pragma once
#include <chrono>

#include <lcmslam/cameras/device_clock.hpp>

namespace lcmslam {

inline Utime wall_clock() {
  using namespace std::chrono;
  return duration_cast<microseconds>(system_clock::now().time_since_epoch()).count();
}

/// Both clocks, of one moment.
inline HostTime host_time() {
  using namespace std::chrono;
  const auto steady = [] {
    return duration_cast<microseconds>(steady_clock::now().time_since_epoch()).count();
  };
  const Utime before = steady(), wall = wall_clock(), after = steady();
  return {wall, before + (after - before) / 2};
}

/// Of a recording's first image, by its setting `start` (s).
inline Utime start_utime(double start) {
  return start > 0 ? static_cast<Utime>(start * 1e6) : wall_clock();
}

}  // namespace lcmslam
