#pragma once
// A log may hold several recordings, one after the other.

#include <optional>

#include <lcmslam/log/log_event.hpp>

namespace lcmslam {

/// Tells where a new recording begins: its events are numbered anew, or time jumps back by more than
/// drivers and networks disorder it.
class SessionTracker {
 public:
  static constexpr Utime largest_disorder = 1'000'000;  // us

  /// To be called with every event; true for the first event of a session, the log's first included.
  bool begins(const LogEventView& event) {
    const bool first = !last_number_ || event.number < *last_number_ ||
                       time_between(last_timestamp_, event.timestamp) < -largest_disorder;
    last_number_ = event.number;
    last_timestamp_ = event.timestamp;
    return first;
  }

 private:
  std::optional<std::int64_t> last_number_;
  Utime last_timestamp_ = 0;
};

}  // namespace lcmslam
