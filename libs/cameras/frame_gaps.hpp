#pragma once
// Images that a camera left out, by the stamps of those that came.

#include <cstdint>
#include <deque>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

class FrameGaps {
 public:
  /// Images that are missing between the last one and this: the stamps' distance in usual ones, but one. The
  /// usual one is the median of the last 15, so that a camera may change its pace (exposure by night).
  std::int64_t missing_before(Utime utime);

  /// us between images; 0 while unknown.
  Utime usual_interval() const;

  void forget() { *this = FrameGaps(); }

 private:
  Utime last_ = 0;
  bool begun_ = false;
  std::deque<Utime> intervals_;
};

}  // namespace lcmslam
