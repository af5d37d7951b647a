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

/// In the log's order, but for this: mappers answer a frame when odometry covers its time, so what odometry
/// is made of (the wheels' readings, say) goes out up to then before the next frame, even where it was logged
/// after it.
class LockstepOrder {
 public:
  using Source = std::function<std::optional<PlayEvent>()>;
  /// `readings`: the channel that odometry is made of; empty: it has none of its own.
  LockstepOrder(Source source, std::string readings)
      : source_(std::move(source)), readings_(std::move(readings)) {}

  std::optional<PlayEvent> next();

  /// Whether readings for the frame before the one that next() gave (at the end: for the last one) went
  /// out. Where the log has none for it, its mappers may never answer.
  bool covered() const { return covers_; }

 private:
  bool pull();
  PlayEvent take(std::size_t i);
  std::optional<std::size_t> find_odometry();

  Source source_;
  std::string readings_;
  std::deque<PlayEvent> ahead_;
  std::optional<Utime> needed_;   // the last frame's newest time, until odometry covers it
  std::optional<Utime> covered_;  // by the readings that went out
  Utime frame_logged_ = 0;
  bool covers_ = true;
};

}  // namespace lcmslam
