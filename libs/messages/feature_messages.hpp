#pragma once
#include <lcmslam/features_t.hpp>

#include "messages/schema.hpp"
#include "surf/feature.hpp"

namespace lcmslam {

features_t to_message(const FeatureFrame& frame);

/// Throws DecodeError for an impossible camera; single features whose values are not finite become
/// bearing-only ones or are left out.
FeatureFrame from_message(const features_t& message);

}  // namespace lcmslam
