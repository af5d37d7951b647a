#pragma once
// What the map says a frame should show, and what the frame's own points say of that.

#include <vector>

#include <lcmslam/fastslam/association/usable_features.hpp>
#include <lcmslam/fastslam/association/visible_landmarks.hpp>
#include <lcmslam/fastslam/settings.hpp>

namespace lcmslam {

/// Well-known landmarks that were seen from about there: how many, and beside which of them a point was
/// measured, behind or at them (free) or before them (hidden).
struct ExpectedLandmarks {
  int landmarks = 0, free = 0, hidden = 0;
  bool are_hidden() const { return hidden > 3 * free; }
  /// Where depth is sparse, few are proved to be anything.
  bool should_be_seen(int enough) const {
    return landmarks >= 2 * enough && (are_hidden() ? hidden >= 2 * enough : free >= enough);
  }
};

ExpectedLandmarks expected_landmarks(const std::vector<VisibleLandmark>& visible, const FeatureFrame& frame,
                                     const std::vector<FeaturePoint>& points,
                                     const Eigen::Isometry3d& T_world_robot, const LandmarkIndex& index,
                                     const FastSlamSettings& settings);

}  // namespace lcmslam
