#pragma once
// The order in which a log's messages go out.

#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include <lcmslam/log/log_event.hpp>

namespace lcmslam {

struct PlayEvent {
  LogEvent event;
  Utime utime = 0;           ///< of the message; log time where it has none
  std::vector<Utime> frame;  ///< of a frame: its utime and those of its images; empty for others
  bool begins_session = false;
};

/// In the log's order, but for this: mappers answer a frame when odometry covers its time, so the wheels'
/// readings up to then go out before the next frame, even where they were logged after it.
class LockstepOrder {
 public:
  using Source = std::function<std::optional<PlayEvent>()>;
  explicit LockstepOrder(Source source) : source_(std::move(source)) {}

  std::optional<PlayEvent> next();

  /// Whether readings for the frame before the one that next() gave (at the end: for the last one) went
  /// out. Where the log has none for it, its mappers may never answer.
  bool covered() const { return covers_; }

 private:
  bool pull();
  PlayEvent take(std::size_t i);
  std::optional<std::size_t> find_odometry();

  Source source_;
  std::deque<PlayEvent> ahead_;
  std::optional<Utime> needed_;   // the last frame's newest time, until odometry covers it
  std::optional<Utime> covered_;  // by the readings that went out
  Utime frame_logged_ = 0;
  bool covers_ = true;
};

}  // namespace lcmslam
