#pragma once
#include <chrono>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

inline Utime wall_clock() {
  using namespace std::chrono;
  return duration_cast<microseconds>(system_clock::now().time_since_epoch()).count();
}

/// Of a recording's first image, by its setting `start` (s).
inline Utime start_utime(double start) {
  return start > 0 ? static_cast<Utime>(start * 1e6) : wall_clock();
}

}  // namespace lcmslam
