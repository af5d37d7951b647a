#pragma once
// The rows of both images, as one number: a calibration has one rolling_shutter for colour and depth.

#include <string>

#include <lcmslam/calibration/self/bundle_adjustment.hpp>

namespace lcmslam {

struct RollingShutter {
  double seconds =
      0;              ///< from an image's first row to its last; the start's where nothing tells one for both
  std::string doubt;  ///< rows that were found and that it does not tell; empty: there are none
};

/// Both images' weighted mean where both are observed, else the one that is; neither where they contradict
/// each other by more than three standard deviations.
RollingShutter rolling_shutter_of(const HeadModel& model, const BundleResult& result,
                                  const BundleSettings& settings);

}  // namespace lcmslam
