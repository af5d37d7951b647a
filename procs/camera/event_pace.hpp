#pragma once
// When the events of a recording are due: at the intervals at which they were measured.

#include <chrono>
#include <map>
#include <optional>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// The stamps of a recording may leap, where a clock was set meanwhile, and wheels may have another clock
/// than images: what leaps goes out at once, and the intervals after it are kept.
class EventPace {
 public:
  using Clock = std::chrono::steady_clock;
  explicit EventPace(double speed) : speed_(speed) {}

  /// Of the next event, of a kind that has one clock.
  Clock::time_point due(std::size_t kind, Utime utime, Clock::time_point now);
  /// It went out so much later than it was due: the pace is kept from here on.
  void delay(Clock::duration late) { start_ += late; }

  /// Leaps so far.
  std::size_t leaps() const { return leaps_; }

 private:
  bool fits(Utime shift, Utime utime) const;

  double speed_;
  Clock::time_point start_;              // when the time of playing was zero
  std::map<std::size_t, Utime> shifts_;  // from the time of playing to each kind's stamps
  std::optional<Utime> last_shift_;      // of the last event
  Utime played_ = 0;                     // time of playing of the last event, us
  std::size_t leaps_ = 0;
};

}  // namespace lcmslam
