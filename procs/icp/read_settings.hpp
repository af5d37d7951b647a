#pragma once
#include "configuration/config.hpp"
#include "icp/icp_mapper.hpp"
#include "imaging/depth_filter.hpp"

namespace lcmslam {

/// Keys are the settings' names, registration's below `coarse` and `fine`; throws ConfigError.
IcpMapperSettings read_icp_settings(const ConfigNode& config);

/// The section `depth_filter`: `parts` in order, and a section for each part's settings.
DepthFilterSettings read_depth_filter_settings(const ConfigNode& config);

}  // namespace lcmslam
