#pragma once
// How often and how evenly messages come, over the last seconds.

#include <cstddef>
#include <deque>

namespace lcmslam {

class ArrivalRate {
 public:
  explicit ArrivalRate(double window) : window_(window) {}

  void add(double time, std::size_t bytes);

  struct Rate {
    double hz = 0;      ///< falls when messages stay away; 0 before the second
    double jitter = 0;  ///< s, standard deviation of the intervals
    double bytes_per_second = 0;
  };
  Rate at(double now) const;

 private:
  struct Arrival {
    double time;
    std::size_t bytes;
  };
  double window_;
  std::deque<Arrival>
      arrivals_;  // oldest first; at least two where there were two: slow channels have a rate
};

}  // namespace lcmslam
