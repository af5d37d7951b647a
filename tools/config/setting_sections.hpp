#pragma once
// Everything that a configuration can say, by its sections: what `lcmslam config`, the completion of --set
// and docs/CONFIGURATION.md are made from.

#include <string>
#include <utility>
#include <vector>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {

struct SettingSection {
  std::string name;
  std::string meaning;
  std::vector<SettingEntry> entries;  ///< with defaults; paths without the section's name
  /// Other defaults, by the preset that has them; in the same order.
  std::vector<std::pair<std::string, std::vector<SettingEntry>>> presets;
  /// Reads the section as its process does. Throws ConfigError.
  void (*read)(const ConfigNode& section);

  std::string key(const SettingEntry& entry) const { return name + "." + entry.path; }
  /// "0.5 (thesis: 1)", "none: must be given".
  std::string defaults(const SettingEntry& entry) const;
};

/// `launch`, and one for each process.
const std::vector<SettingSection>& setting_sections();

/// docs/CONFIGURATION.md.
std::string configuration_page();

}  // namespace lcmslam
