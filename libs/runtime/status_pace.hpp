#pragma once
// When STATUS goes out: each second; at once when the state has changed; soon when the words have, or when
// there is more trouble (refused messages, no processor). Words may count seconds and strangers may send on
// and on: neither makes more than some a second.

#include <chrono>

#include <lcmslam/runtime/node.hpp>

namespace lcmslam {

class StatusPace {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Whether this is to be told now; then it counts as told. `troubles`: how many there were so far.
  bool due(const NodeReport& report, std::int64_t troubles, Time now);

 private:
  int state_ = -1;
  std::string words_;
  std::int64_t troubles_ = 0;
  Time next_{}, next_words_{}, next_troubles_{};
};

}  // namespace lcmslam
