#pragma once
// What a feature's filters covered. A blob that straddles an edge of depth belongs to no surface: as the
// camera goes on, what lies behind slides along the edge, and the blob's middle goes with both.

#include <lcmslam/features/feature.hpp>
#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>

namespace lcmslam {

/// Leaves out features with a 3-D point around which depth is not one smooth surface: where, of two opposite
/// places within 1.5 of its radii, the mean of 1/z is off its own by more than `largest_step`, ratio. Places
/// without depth say nothing. `T_colour_depth_time` as for DepthRegistration. Returns how many were left out.
int leave_out_straddling(const RgbdFrame& frame, const RgbdCalibration& calibration,
                         const Eigen::Isometry3d& T_colour_depth_time, double largest_step,
                         FeatureFrame& features);

}  // namespace lcmslam
