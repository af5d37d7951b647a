#pragma once
// SURF correspondences between two images as pairs of 3-D points: S_SURF and T_SURF of algorithm 3.2.

#include <vector>

#include <lcmslam/features/feature.hpp>

namespace lcmslam {

/// Corresponding 3-D points (m), i of one with i of the other: source frame and target frame.
struct FeaturePairs {
  std::vector<Eigen::Vector3f> source, target;
};

/// Matches with depth at both ends, in the colour cameras' frames; with `checked` only those that agree on
/// one rigid motion (RANSAC).
FeaturePairs feature_pairs(const FeatureFrame& source, const FeatureFrame& target, bool checked);

}  // namespace lcmslam
