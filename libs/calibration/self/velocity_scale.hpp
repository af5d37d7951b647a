#pragma once
// By how much the keyframes' velocities are too small or too large.

#include <vector>

#include <lcmslam/calibration/self/scene_observations.hpp>

namespace lcmslam {

struct VelocityScale {
  double translation = 1, rotation = 1;
};

/// From the ways and turns between the keyframes where they are known to be now, and as they were told by
/// what told the velocities: wheels whose radii are off, images whose focal length was.
VelocityScale velocity_scale(const std::vector<ObservedKeyframe>& keyframes);

}  // namespace lcmslam
