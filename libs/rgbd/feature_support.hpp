#pragma once
// What a feature's filters covered. A blob that straddles an edge of depth belongs to no surface: as the
// camera goes on, what lies behind slides along the edge, and the blob's middle goes with both.

#include <lcmslam/features/feature.hpp>
#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct FeatureSupportSettings {
  double largest_depth_step = 0.05;
  int least_features = 500;

  void describe(SettingsVisitor& s) {
    s.number("largest_depth_step", largest_depth_step, "", {0, 1000},
             "ratio: a feature beside which 1/z leaves the plane of its surface by more lies on an edge of "
             "depth, moves with the view, and is left out");
    s.number("least_features", least_features, "", {0, 5000},
             "of an image that are kept whatever lies beside them; those on the largest steps go first");
  }
};

/// Leaves out features with a 3-D point around which depth is not one smooth surface: where, of two opposite
/// places within 1.5 of its radii, the mean of 1/z is off its own by more than `largest_depth_step`. Places
/// without depth say nothing. `T_colour_depth_time` as for DepthRegistration. Returns how many were left out.
int leave_out_straddling(const RgbdFrame& frame, const RgbdCalibration& calibration,
                         const Eigen::Isometry3d& T_colour_depth_time, const FeatureSupportSettings& settings,
                         FeatureFrame& features);

}  // namespace lcmslam
