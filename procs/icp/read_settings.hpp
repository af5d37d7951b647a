#pragma once
#include <lcmslam/configuration/config.hpp>
#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include <lcmslam/imaging/depth_filter.hpp>

namespace lcmslam {

/// Keys are the settings' names, registration's below `coarse` and `fine`; throws ConfigError.
DenseMapperSettings read_icp_settings(const ConfigNode& config);

/// The section `depth_filter`: `parts` in order, and a section for each part's settings.
DepthFilterSettings read_depth_filter_settings(const ConfigNode& config);

}  // namespace lcmslam
