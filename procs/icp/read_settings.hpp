#pragma once
#include "configuration/config.hpp"
#include "icp/icp_mapper.hpp"

namespace lcmslam {

/// Keys are the settings' names, registration's below `coarse` and `fine`; throws ConfigError.
IcpMapperSettings read_icp_settings(const ConfigNode& config);

}  // namespace lcmslam
