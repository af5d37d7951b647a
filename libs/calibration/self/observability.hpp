#pragma once
#include <string>
#include <vector>

#include <lcmslam/calibration/self/bundle_adjustment.hpp>

namespace lcmslam {

/// Combinations of parameters whose sigma is still more than `share` of what the start said, in words:
/// parameters may each be known by what the start says of another.
std::vector<std::string> unobserved_directions(const BundleResult& result, double share);

}  // namespace lcmslam
