#pragma once
// The slope of a landmark's surface in a depth image, as its other sightings tell it.

#include <lcmslam/calibration/self/sighting_comparison.hpp>

namespace lcmslam {

/// Each patch keeps its own depth, and takes its slope from those in which other keyframes saw the same
/// landmark; where fewer than two of them agree with its own within 20 degrees, that stays. From `first` to
/// before `last`: all of one landmark; `camera`: the depth camera.
///
/// Noise that differs over a patch, as it does on a slanted surface, errs in depth and slope together. What a
/// residual says of the head is weighed by the slope: its own would favour one side in every image.
void share_slopes(Comparison* first, Comparison* last, const BundleState& state, const CameraModel& camera,
                  const Eigen::Isometry3d& T_depth_colour);

}  // namespace lcmslam
