#pragma once
// What was found, for people and as a file.

#include <string>

#include <lcmslam/self_calibration/bundle_adjustment.hpp>

namespace lcmslam {

/// A table: each parameter before and after, its change and sigma, and what was not observed.
std::string report_text(const HeadModel& model, const BundleResult& result, const BundleSettings& settings);

/// A calibration file (config/calibration/tum_fr1.yaml explains its keys) with sigmas and correlations;
/// `note` stands above it as a comment.
std::string calibration_yaml(const HeadModel& model, const BundleResult& result, const std::string& note);

}  // namespace lcmslam
