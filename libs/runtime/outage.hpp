#pragma once
// What fails again and again is said without flooding the log.

#include <cstdint>
#include <utility>

namespace lcmslam {

class Outage {
 public:
  /// Whether this failure is to be said: the 1st, 2nd, 4th, 8th ... of an outage.
  bool failed() {
    ++failures_;
    return (failures_ & (failures_ - 1)) == 0;
  }
  std::int64_t failures() const { return failures_; }
  /// It works. Gives the failures of the outage that ends so; 0: there was none.
  std::int64_t over() { return std::exchange(failures_, 0); }

 private:
  std::int64_t failures_ = 0;
};

}  // namespace lcmslam
