#pragma once
#include <string>

#include <lcmslam/calibration/range_error.hpp>

namespace lcmslam {

/// What a depth camera's ranges err by, a line each.
std::string range_report(const RangeErrorFit& fit);

}  // namespace lcmslam
