#pragma once
// The prior of a step: how far the robot moved, and how well that is known.

#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>

namespace lcmslam {

/// The odometry's motion with the covariance that the filter believes: the odometry's own (wider when
/// the odometry is visual) plus the noise of the settings. Planar settings keep (x, y, heading) only.
/// A motion that is not finite becomes "no idea": standing still, 0.5 m and 0.5 rad.
Motion motion_prior(const Motion& odometry, const FastSlamSettings& settings);

/// Without odometry the robot may have gone anywhere that its speed allows: 0.5 m and 1 rad a second, in us.
Motion unknown_motion(Utime elapsed);

/// Finite, symmetric, and not so wide that numbers fail.
bool usable(const Motion& motion);

}  // namespace lcmslam
