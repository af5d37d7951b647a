#pragma once
#include <opencv2/features2d.hpp>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/imaging/depth_registration.hpp>

namespace lcmslam {

/// Features of a colour image with their 3-D points: those of its registered depth. `detector` must give 64
/// floats in -1..1 a feature, as SURF does; throws std::invalid_argument for another one.
FeatureFrame describe_frame(const RgbdFrame& frame, const RegisteredDepth& depth,
                            const RgbdCalibration& calibration, cv::Feature2D& detector);

/// The same, bit for bit, but only what lies around the features is registered. `T_colour_depth_time` as for
/// DepthRegistration.
FeatureFrame describe_frame(const RgbdFrame& frame, const DepthRegistration& registration,
                            const Eigen::Isometry3d& T_colour_depth_time, cv::Feature2D& detector);

}  // namespace lcmslam
