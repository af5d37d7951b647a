#pragma once
#include <utility>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// Which image of one camera belongs to which of another, one to one, nearest stamps first, none farther
/// apart than `max_difference` (us). Both lists are sorted; gives indices, in the order in which they were
/// found.
std::vector<std::pair<std::size_t, std::size_t>> pair_by_stamps(const std::vector<Utime>& a,
                                                                const std::vector<Utime>& b,
                                                                Utime max_difference);

}  // namespace lcmslam
