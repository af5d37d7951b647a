#pragma once
#include <utility>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// Which colour image belongs to which depth image, one to one, nearest first, none farther apart than
/// `max_difference` (us). `depth_offset` (us), added to depth's stamps, gives colour's clock
/// (RgbdCalibration). Both lists are sorted; gives indices, in the order in which they were found.
std::vector<std::pair<std::size_t, std::size_t>> pair_by_stamps(const std::vector<Utime>& colour,
                                                                const std::vector<Utime>& depth,
                                                                Utime depth_offset, Utime max_difference);

}  // namespace lcmslam
