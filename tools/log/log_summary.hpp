#pragma once
// What is in a log: `lcmslam log info`.

#include <map>
#include <string>
#include <vector>

#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/runtime/sender_counts.hpp>
#include "tools/log/part_joiner.hpp"

namespace lcmslam {

struct ChannelSummary {
  std::map<std::uint64_t, std::int64_t> types;  ///< messages by fingerprint, of the first few types
  std::int64_t other_types = 0;                 ///< messages of further types
  std::int64_t untyped = 0;                     ///< messages of less than 8 bytes
  std::int64_t count = 0, bytes = 0, largest = 0;
  Utime largest_gap = 0;        ///< us, within a session
  std::int64_t jumps_back = 0;  ///< messages logged with an earlier time than the one before
  double rate = 0;              ///< Hz, over the sessions' times
  SenderCounts senders;         ///< of numbered types; lost = gaps in seq
};

struct SessionSummary {
  std::uint64_t offset = 0;
  Utime first = 0, last = 0;  ///< smallest and largest log time
  std::int64_t events = 0;
};

struct LogSummary {
  std::string file;
  std::uint64_t size = 0;
  std::int64_t events = 0;
  std::int64_t jumps_back = 0;
  Utime largest_jump_back = 0;  ///< us, within a session
  std::vector<SessionSummary> sessions;
  std::map<std::string, ChannelSummary> channels;
  std::map<std::string, PartJoiner::Count> in_pieces;
  std::vector<LogDamage> damages;
};

/// Throws std::runtime_error when the file is no log.
LogSummary summarise_log(const std::string& file);

std::string format_summary(const LogSummary& summary);
std::string summary_json(const LogSummary& summary);

/// Name of a type, or its fingerprint in hex when it is unknown.
std::string type_name(std::uint64_t fingerprint);

}  // namespace lcmslam
