#pragma once
#include <cstddef>
#include <string>

#include "tools/launch/status_table.hpp"

namespace lcmslam {

/// "    3 s  starting: 2 of 6 processes", and what those that still start say: what they wait for.
std::string format_start(double elapsed, const StatusBoard& board, std::size_t processes);

}  // namespace lcmslam
