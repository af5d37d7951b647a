#pragma once
// What each sighting of a landmark is compared to: the pixel where it was seen, and the surface that the
// depth camera measured where the landmark lies in its image.

#include <optional>
#include <vector>

#include <lcmslam/calibration/self/bundle_adjustment.hpp>
#include <lcmslam/calibration/self/bundle_state.hpp>
#include <lcmslam/calibration/self/residuals.hpp>

namespace lcmslam {

struct Comparison {
  std::size_t keyframe, landmark;
  residuals::Reprojection pixel;
  std::optional<residuals::Patch> patch;  ///< nothing: no smooth surface, or another one
  RangeCurve::Place range;                ///< as measured there
  double lag = 0, row = 0;                ///< of depth
};

struct Comparisons {
  std::vector<Comparison> all;
  int pixels = 0, depths = 0;
  /// Standard deviations as they are seen to be, over those that sightings and calibration state.
  double pixel_scale = 1, depth_scale = 1;
};

/// By the present values. What is too far off is left out: at first (`former` null) by the settings' gates,
/// then by the scales that were seen. Throws std::runtime_error when too little is left.
Comparisons compare(const BundleState& state, const BundleSettings& settings, const Comparisons* former);

}  // namespace lcmslam
