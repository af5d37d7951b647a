#pragma once
// Whether messages that came regularly have stopped coming.

#include <chrono>

namespace lcmslam {

class Pulse {
 public:
  using Time = std::chrono::steady_clock::time_point;

  void beat(Time now);
  /// Far longer without a beat than they were apart; never before there were enough to know.
  bool stopped(Time now) const;

 private:
  Time last_;
  int beats_ = 0;
  int late_ = 0;       // beats in a row that came after a stop
  double period_ = 0;  // s, mean of the newest
};

}  // namespace lcmslam
