#pragma once
// What a log has for the graph, by its headers alone: before the first frame is mapped it must be clear that
// frames can be mapped, and from what.

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <lcmslam/log/log_event.hpp>

namespace lcmslam {

/// The span of a log that is mapped, s from its start. Logs are in disorder, or hold several sessions: each
/// event is judged by its own time.
struct LogSpan {
  double from = 0;
  double to = 0;  ///< 0: the log's end

  bool is_before(double seconds) const { return seconds < from; }
  bool holds(double seconds) const { return !is_before(seconds) && (to <= 0 || seconds <= to); }
};

struct LogOffer {
  std::map<std::string, std::int64_t> messages;  ///< by channel, those within the span
  std::map<std::string, std::set<std::string>>
      by_type;              ///< channels by their messages' type, where it is known
  bool calibrated = false;  ///< there is a CAMERA_CALIBRATION before the span's end

  bool has(const std::string& channel) const { return messages.count(channel) > 0; }
  /// The channels with the names of their types, for messages of errors.
  std::string listed() const;
};

/// Messages in pieces count as whole ones of their channel. Throws std::runtime_error when the file is no
/// log.
LogOffer read_offer(const std::filesystem::path& log, const LogSpan& span);

}  // namespace lcmslam
