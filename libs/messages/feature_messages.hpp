#pragma once
#include <lcmslam/features/feature.hpp>
#include <lcmslam/features_t.hpp>
#include <lcmslam/messages/schema.hpp>

namespace lcmslam {

features_t to_message(const FeatureFrame& frame);

/// Throws DecodeError for an impossible camera; single features whose values are not finite become
/// bearing-only ones or are left out.
FeatureFrame from_message(const features_t& message);

}  // namespace lcmslam
