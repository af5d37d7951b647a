#pragma once
// How much may be under way on a link that nobody knows: as much as it carries, but no more, so that what is
// new does not wait behind what is old in somebody's send buffer.
//
// A message is under way until the broker has acknowledged it. Its time is that of the link plus that of the
// queue in front of it; the smallest time of the last half minute is the link's own. While the queue takes
// less than `delay`, a full window grows, at first as fast as TCP's, after the first queue by a message each
// time round (LEDBAT, RFC 6817, does much the same). When all messages of a second took longer, and from time
// to time anyway, the window becomes what the link alone holds, and a little less, so that the queue ends and
// the link's own time is seen again. One slow message is no queue: a radio that loses packets holds up all
// behind them until they have been sent again.

#include <chrono>
#include <cstddef>
#include <deque>
#include <utility>

namespace lcmslam::bridge {

using Time = std::chrono::steady_clock::time_point;

class LinkWindow {
 public:
  /// `delay`: s that the queue may take.
  explicit LinkWindow(double delay) : delay_(delay) {}

  /// One message always, however big it is; one beside small ones, so that those do not keep it waiting.
  bool admits(std::size_t bytes) const {
    const bool room = in_flight_ + bytes <= window_ || (bytes > window_ && 2 * in_flight_ <= window_);
    return messages_ == 0 || (messages_ < most_messages && room);
  }
  void sent(std::size_t bytes);
  /// Of a message that was sent at `sent`.
  void acknowledged(std::size_t bytes, Time sent, Time now);
  /// The connection is another one.
  void reset();

  std::size_t window() const { return window_; }
  std::size_t in_flight() const { return in_flight_; }
  static constexpr std::size_t most_messages = 20;  ///< that brokers take before they acknowledge

 private:
  static constexpr std::size_t least = 10'000, most = 4'000'000, first = 32'000;  // bytes

  /// The smallest of a while's times.
  class Smallest {
   public:
    explicit Smallest(double memory) : memory_(memory) {}
    void add(Time at, double time);
    double operator()() const { return candidates_.front().second; }

   private:
    double memory_;                                   // s
    std::deque<std::pair<Time, double>> candidates_;  // ascending
  };
  static constexpr double lately = 1, long_ago = 30, patience = 10;  // s

  double delay_;
  std::size_t window_ = first, in_flight_ = 0, messages_ = 0;
  Smallest own_{long_ago}, newest_{lately};
  bool searching_ = true;  // no queue was seen yet
  Time shrunk_{};          // the last time, or when the first answer came
};

}  // namespace lcmslam::bridge
