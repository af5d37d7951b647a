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
  double roller_angle = 0;  ///< rad from the rolling direction to the axis of the roller on the ground,
                            ///< counter-clockwise from above: +-pi/4 mecanum, next to 0 (1e-6) an omni wheel;
                            ///< 0: plain tyre, rolls without side slip
  double angle = 0;         ///< rad turned about its axle since start, forward positive (cumulative)
  double steering = 0;      ///< rad, direction of rolling measured from x; 0 for fixed wheels
};

struct Encoders {
  Utime utime = 0;
  std::int64_t seq = 0;
  std::int64_t sender = 0;  ///< the driver's process, which counts from its own start; 0: unknown
  std::vector<Wheel> wheels;
};

}  // namespace lcmslam
