#pragma once
// Which source points take part.

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/registration/registration_settings.hpp>

namespace lcmslam {

/// Indices of the selected points, ascending. Points that are not finite never take part; normal_space and
/// stable leave out those without a normal, and select like random where no point has one.
std::vector<std::size_t> select_points(const Cloud& source, const RegistrationSettings& settings);

}  // namespace lcmslam
