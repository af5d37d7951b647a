#pragma once
// When the next message of a log may go out.

#include <chrono>
#include <optional>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// Keeps the log's intervals, faster or slower.
class LogClock {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `speed` 1: as recorded; 0: as fast as possible.
  explicit LogClock(double speed) : speed_(speed) {}

  /// When the event is due. What comes late, or in a time that jumps back, follows at once.
  Time due(Utime timestamp, Time now);
  /// The next event follows at once, whatever its time (another session, a loop).
  void restart() { anchor_.reset(); }

  /// Seconds of the log that were played.
  double played() const { return played_; }

 private:
  struct Anchor {
    Utime timestamp;
    Time time;
  };
  double speed_;
  std::optional<Anchor> anchor_;
  Utime last_ = 0;
  double played_ = 0;
};

/// Leaves receivers the time to empty their sockets: the kernel charges some 2 kB for each datagram against
/// a buffer that is 200 kB by default, and a receiver may not run for some ms.
class SocketPace {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// When a message of so many bytes may go out; to be sent then.
  Time due(std::size_t bytes, Time now);

 private:
  Time free_{};  // when all that was sent has been received, at the rate assumed
};

}  // namespace lcmslam
