#pragma once
#include <lcmslam/configuration/config.hpp>
#include <lcmslam/fastslam/settings.hpp>

namespace lcmslam {

/// Keys are the settings' names; throws ConfigError.
FastSlamSettings read_fastslam_settings(const ConfigNode& config);

}  // namespace lcmslam
