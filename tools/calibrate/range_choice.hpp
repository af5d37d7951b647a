#pragma once
#include <string>
#include <vector>

#include <lcmslam/calibration/range_error.hpp>
#include "tools/calibrate/live_views.hpp"

namespace lcmslam {

/// m: over as much a wiggle of the ranges tells itself from an offset.
constexpr WantedRanges whole_period{1.0, 2.4};

struct RangeChoice {
  DepthError error;
  std::vector<std::string> kept;  ///< what stays as it was, and why
};

/// What a calibration takes of a new fit: one of a few ranges knows less than the calibration may do already.
/// Tilts are never fitted and stay.
RangeChoice choose_range_error(const DepthError& base, const RangeErrorFit& fit);

}  // namespace lcmslam
