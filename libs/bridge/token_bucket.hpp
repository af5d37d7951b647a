#pragma once
// A rate that is not exceeded for longer than a burst.

#include <algorithm>
#include <chrono>

namespace lcmslam::bridge {

class TokenBucket {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `rate` in units (bytes, messages) a second, 0: no limit. So many units may come at once.
  TokenBucket(double rate, double burst) : rate_(rate), burst_(burst), tokens_(burst) {}

  /// Whether something may pass now. What is larger than the burst passes when the bucket is full, and leaves
  /// a debt.
  bool has(double units, Time now) {
    if (rate_ <= 0) return true;
    refill(now);
    return tokens_ >= std::min(units, burst_);
  }
  void take(double units, Time now) {
    if (rate_ <= 0) return;
    refill(now);
    tokens_ -= units;
  }
  bool try_take(double units, Time now) {
    if (!has(units, now)) return false;
    take(units, now);
    return true;
  }

 private:
  void refill(Time now) {
    if (last_ != Time{})
      tokens_ = std::min(burst_, tokens_ + rate_ * std::chrono::duration<double>(now - last_).count());
    last_ = now;
  }

  double rate_, burst_, tokens_;
  Time last_{};
};

}  // namespace lcmslam::bridge
