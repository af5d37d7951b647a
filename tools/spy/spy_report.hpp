#pragma once
// What spy shows.

#include <string>
#include <vector>

#include <lcmslam/runtime/machine.hpp>
#include <lcmslam/runtime/refusals.hpp>
#include "tools/spy/bus_statistics.hpp"

namespace lcmslam {

struct SpyReport {
  std::string lcm_url;
  double seconds = 0;  ///< listened so far
  std::vector<ChannelReport> channels;
  std::int64_t left_out = 0;  ///< messages on channels beyond the most that are counted
  SocketState socket;         ///< of spy itself
  Refusals refusals;          ///< what came to it and was not taken
  std::int64_t dropped = 0;   ///< messages that came faster than spy counts
};

/// A table and the state of spy's own socket below it: what was lost there is not the bus's loss.
std::string spy_text(const SpyReport& report);

/// One line.
std::string spy_json(const SpyReport& report);

/// The lines that a terminal of this size can show, and a word on those that it cannot.
std::string fit_to_screen(const std::string& text, std::size_t rows, std::size_t columns);

}  // namespace lcmslam
