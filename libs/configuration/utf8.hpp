#pragma once
#include <cstddef>
#include <optional>
#include <string>

namespace lcmslam {

/// Bytes of the well-formed UTF-8 character at i (RFC 3629), none when there is no such.
std::optional<std::size_t> utf8_character_size(const std::string& text, std::size_t i);

}  // namespace lcmslam
