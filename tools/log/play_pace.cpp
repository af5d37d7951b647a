#include "tools/log/play_pace.hpp"

#include <algorithm>

#include <lcmslam/log/log_event.hpp>

namespace lcmslam {
namespace {

constexpr Utime largest_disorder = 1'000'000;  // us, of log times
constexpr double century = 3e9;                // s; a time that no wait reaches must not overflow
constexpr double datagram = 2304;              // bytes, charged on top of the payload
constexpr double burst = 64e3;                 // bytes that sockets take at once
constexpr double rate = 48e6;                  // bytes/s
constexpr std::size_t largest = 48'000;        // bytes that count of a message; the sender paces the big ones

}  // namespace

LogClock::Time LogClock::due(Utime timestamp, Time now) {
  const Utime step = time_between(last_, timestamp);
  if (!anchor_ || step < -largest_disorder) {
    anchor_ = {timestamp, now};
    last_ = timestamp;
    return now;
  }
  if (step > 0) {
    played_ += 1e-6 * static_cast<double>(step);
    last_ = timestamp;
  }
  if (speed_ == 0) return now;
  const double since = 1e-6 * static_cast<double>(time_between(anchor_->timestamp, timestamp)) / speed_;
  return anchor_->time +
         std::chrono::round<Time::duration>(std::chrono::duration<double>(std::min(since, century)));
}

SocketPace::Time SocketPace::due(std::size_t bytes, Time now) {
  const auto duration = [](double amount) {
    return std::chrono::duration_cast<Time::duration>(std::chrono::duration<double>(amount / rate));
  };
  free_ = std::max(free_, now) + duration(datagram + static_cast<double>(std::min(bytes, largest)));
  return std::max(now, free_ - duration(burst));
}

}  // namespace lcmslam
