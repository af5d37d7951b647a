#include <lcmslam/cameras/frame_gaps.hpp>

#include <algorithm>
#include <vector>

namespace lcmslam {
namespace {

constexpr std::size_t remembered = 15;
constexpr std::size_t needed = 5;          // intervals that make a usual one
constexpr Utime longest_gap = 10'000'000;  // us; more is a clock that was set, not a camera

}  // namespace

Utime FrameGaps::usual_interval() const {
  if (intervals_.size() < needed) return 0;
  std::vector<Utime> sorted(intervals_.begin(), intervals_.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

std::int64_t FrameGaps::missing_before(Utime utime) {
  const Utime interval = utime - last_;
  const bool first = !begun_;
  begun_ = true;
  last_ = utime;
  if (first || interval <= 0 || interval > longest_gap) return 0;
  const Utime usual = usual_interval();
  intervals_.push_back(interval);
  if (intervals_.size() > remembered) intervals_.pop_front();
  return usual > 0 ? std::max<std::int64_t>((interval + usual / 2) / usual - 1, 0) : 0;
}

}  // namespace lcmslam
