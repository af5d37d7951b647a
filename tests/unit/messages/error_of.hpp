#pragma once
#include <string>

#include <lcmslam/messages/schema.hpp>

namespace lcmslam::testing {

/// What DecodeError said; empty when there was none.
template <class Function>
std::string error_of(Function function) {
  try {
    function();
    return {};
  } catch (const DecodeError& error) {
    return error.what();
  }
}

}  // namespace lcmslam::testing
