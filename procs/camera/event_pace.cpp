#include "procs/camera/event_pace.hpp"

#include <lcmslam/log/log_event.hpp>

namespace lcmslam {

EventPace::Clock::time_point EventPace::due(std::size_t kind, Utime utime, Clock::time_point now) {
  const auto own = shifts_.find(kind);
  if (!last_shift_) {
    start_ = now;
    last_shift_ = utime;
  } else if (own != shifts_.end() && fits(own->second, utime)) {
    last_shift_ = own->second;
  } else if (!fits(*last_shift_, utime)) {  // else the other kinds have leapt already
    last_shift_ = time_between(played_, utime);
    ++leaps_;
  }
  shifts_[kind] = *last_shift_;
  played_ = time_between(*last_shift_, utime);
  const std::chrono::duration<double> offset(1e-6 * static_cast<double>(played_) / speed_);
  return start_ + std::chrono::duration_cast<Clock::duration>(offset);
}

/// No clock leaps where so little lies between two events.
bool EventPace::fits(Utime shift, Utime utime) const {
  constexpr Utime disorder = 1'000'000, longest_pause = 10'000'000;  // us
  const Utime step = time_between(played_, time_between(shift, utime));
  return step >= -disorder && step <= longest_pause;
}

}  // namespace lcmslam
