#pragma once
// Strict reading of single values. Internal to lcmslam_configuration.

#include <optional>
#include <string>
#include <vector>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/configuration/nearest_word.hpp>
#include <lcmslam/configuration/yaml_tree.hpp>

namespace lcmslam {

/// Nothing unless the value is exactly of that kind; numbers finite and within the range.
std::optional<double> read_number(const YamlValue& value, const Range& range);
std::optional<int> read_whole_number(const YamlValue& value, const Range& range);
std::optional<bool> read_bool(const YamlValue& value);
std::optional<std::string> read_text(const YamlValue& value);

}  // namespace lcmslam
