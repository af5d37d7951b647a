#pragma once
// Choices of a configuration that stand for values of an enumeration.

#include <map>
#include <string>
#include <vector>

#include <lcmslam/configuration/config.hpp>

namespace lcmslam {

/// The value behind the name that stands under `key`; throws ConfigError for a name that is not there.
template <class T>
T named_choice(const ConfigNode& config, const std::string& key, T fallback,
               const std::map<std::string, T>& names) {
  std::vector<std::string> choices;
  std::string standard;
  for (const auto& [name, value] : names) {
    choices.push_back(name);
    if (value == fallback) standard = name;
  }
  return names.at(config.choice(key, standard, choices));
}

}  // namespace lcmslam
