#pragma once
// What a wheeled base measures, and where its wheels are: one description for fixed, steered and
// mecanum wheels, so that one estimator serves every base.

#include <cstdint>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// One wheel, in the robot frame (x forward, y left).
struct Wheel {
  double x = 0, y = 0;      ///< ground contact, m
  double radius = 0.1;      ///< m
  double roller_angle = 0;  ///< rad between the wheel's axle and its rollers' axes; 0: plain tyre (rolls
                            ///< without side slip); +-pi/4: mecanum
  double angle = 0;         ///< rad turned about its axle since start, forward positive (cumulative)
  double steering = 0;      ///< rad, direction of rolling measured from x; 0 for fixed wheels
};

struct Encoders {
  Utime utime = 0;
  std::int64_t seq = 0;
  std::vector<Wheel> wheels;
};

}  // namespace lcmslam
