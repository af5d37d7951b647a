#pragma once
#include <string>

#include <lcmslam/calibration/view_coverage.hpp>

namespace lcmslam {

/// What a calibration of a camera says of itself, a line each: values with their standard deviations, errors,
/// coverage.
std::string camera_report(const CameraCalibration& calibration, const ViewCoverage& coverage);
/// Names of its covariance's rows.
std::vector<std::string> intrinsic_names(const CameraModel& camera);
std::string camera_covariance(const CameraCalibration& calibration, const std::string& of);
/// coverage.png and residuals.png, into a folder that is made where it is missing.
void write_pictures(const CameraCalibration& calibration, const Board& board, const std::string& folder);

}  // namespace lcmslam
