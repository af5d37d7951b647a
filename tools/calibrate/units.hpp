#pragma once
#include <cmath>

namespace lcmslam {

// What people read in reports; everything else is in metres and radians.
constexpr double mm_per_m = 1e3, degrees_per_rad = 180 / M_PI;

}  // namespace lcmslam
