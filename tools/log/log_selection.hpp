#pragma once
// Which events of a log are wanted: a span of time, some channels.

#include <optional>
#include <set>
#include <string>

#include <lcmslam/log/log_event.hpp>

namespace lcmslam {

/// A place in time: seconds from the log's first event, or the utime itself (us) when above 1e9.
struct LogTime {
  double value = 0;
  Utime utime(Utime first) const;
};

struct LogSelection {
  std::optional<LogTime> from, to;         ///< from <= log time < to
  std::set<std::string> channels;          ///< only these; all when empty
  std::set<std::string> without_channels;  ///< not these

  /// Throws std::invalid_argument, naming the values, when nothing can be selected.
  void check() const;

  /// Throws std::runtime_error when a channel that is asked for or left out is none of those that the log
  /// has.
  void check_channels(const std::set<std::string>& in_log, const std::string& log) const;

  bool has_channel(const std::string& channel) const {
    return (channels.empty() || channels.count(channel) > 0) && without_channels.count(channel) == 0;
  }
  bool has_time(Utime timestamp, Utime first) const {
    return !is_before(timestamp, first) && (!to || timestamp < to->utime(first));
  }
  bool is_before(Utime timestamp, Utime first) const { return from && timestamp < from->utime(first); }
};

}  // namespace lcmslam
