#pragma once
#include <string>

#include <lcmslam/configuration/config.hpp>

namespace lcmslam {

/// The ConfigError's text, "no error" if there is none.
template <class Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace lcmslam
