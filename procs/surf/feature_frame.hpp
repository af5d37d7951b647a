#pragma once
#include <lcmslam/features/feature.hpp>
#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/surf/surf.hpp>

namespace lcmslam {

/// SURF features of a colour image with their 3-D points: those of its registered depth.
FeatureFrame describe_frame(const RgbdFrame& frame, const RegisteredDepth& depth,
                            const RgbdCalibration& calibration, Surf& surf);

}  // namespace lcmslam
