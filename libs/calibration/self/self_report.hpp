#pragma once
// What was found, for people and as a file.

#include <string>

#include <lcmslam/calibration/self/bundle_adjustment.hpp>

namespace lcmslam {

/// A table: each parameter before and after, its change and sigma, what was not observed, and what was and a
/// calibration cannot say.
std::string report_text(const HeadModel& model, const BundleResult& result, const BundleSettings& settings);

/// For the file beside the calibration: of what was free.
std::string self_covariance_text(const BundleResult& result);

}  // namespace lcmslam
