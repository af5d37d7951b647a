#pragma once
// The secret of a bus that others can reach.

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace lcmslam {

using BusKey = std::array<std::uint8_t, 32>;

/// From a file of 64 hexadecimal digits that nobody but its owner may read. Throws std::invalid_argument that
/// names the file and what would be right.
BusKey read_bus_key(const std::string& file);

/// Of the file that LCMSLAM_BUS_KEY names; nothing without. An environment variable for the same reason as
/// LCMSLAM_BUS_ALLOW.
std::optional<BusKey> bus_key();

}  // namespace lcmslam
