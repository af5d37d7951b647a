#pragma once
// Messages that were logged in pieces (<CHANNEL>_PART) become whole again.

#include <map>
#include <set>

#include <lcmslam/log/log_event.hpp>
#include <lcmslam/messages/parts.hpp>

namespace lcmslam {

class PartJoiner {
 public:
  /// Whether the event is a piece: a part_t on a channel of pieces.
  static bool is_piece(const LogEventView& event);

  /// The whole message with the number and log time of its last piece, when this piece completes it.
  /// Throws DecodeError for a piece that contradicts itself or the others.
  std::optional<LogEvent> add(const LogEventView& piece);

  struct Count {
    std::int64_t pieces = 0, whole = 0, incomplete = 0;
  };
  /// So far, by the channel of the whole messages.
  std::map<std::string, Count> counts() const;

 private:
  struct Channel {
    std::int64_t pieces = 0;
    std::set<std::pair<std::int64_t, std::int64_t>> begun, whole;  // sender, message
  };
  PartAssembler assembler_{std::size_t{1} << 28};  // bytes, LCM's own limit: a log is no stranger
  std::map<std::string, Channel> channels_;
};

}  // namespace lcmslam
