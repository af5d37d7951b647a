#pragma once
// What is wrong with a log: `lcmslam log check`.

#include <set>
#include <string>
#include <vector>

#include <lcmslam/log/log_reader.hpp>
#include "tools/log/definition_files.hpp"

namespace lcmslam {

struct LogFinding {
  std::int64_t number = -1;  ///< of the event; -1: none
  std::uint64_t offset = 0;  ///< bytes
  std::string channel;       ///< empty: none
  std::string text;
};

struct LogCheck {
  std::vector<LogFinding> findings;  ///< in the file's order
  std::int64_t events = 0;
  std::int64_t sessions = 0;
  std::int64_t jittered =
      0;                     ///< logged up to 0.1 s before the event before: lcm-logger does that, no finding
  Utime largest_jitter = 0;  ///< us, of those
  std::int64_t unknown_types = 0;          ///< events whose type is not known: only their framing was checked
  std::set<std::string> unknown_channels;  ///< where those are
};

/// Framing, event numbers, order in time, layout of every message of a known type, utime against log
/// time, messages in pieces, and whether the nodes would take what they contain (images are decoded). Throws
/// std::runtime_error when the file is no log. `types` are known besides those of lcmtypes/.
LogCheck check_log(const std::string& file, const KnownTypes& types = {});

/// One line.
std::string format_finding(const LogFinding& finding);

}  // namespace lcmslam
