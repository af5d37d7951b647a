#include "tools/log/play_order.hpp"

#include <algorithm>

namespace lcmslam {
namespace {

constexpr Utime farthest = 500'000;  // us; readings that were logged later than this are not waited for

}  // namespace

std::optional<PlayEvent> LockstepOrder::next() {
  const bool end = ahead_.empty() && !pull();
  if (!end && ahead_.front().frame.empty()) return take(0);
  covers_ = !needed_ || !covered_;  // a log without readings needs none
  if (end) return std::nullopt;
  if (needed_)
    if (const auto found = find_odometry()) return take(*found);
  return take(0);
}

/// The next reading, if it lies near the last frame.
std::optional<std::size_t> LockstepOrder::find_odometry() {
  for (std::size_t i = 0; i < ahead_.size() || pull(); ++i) {
    const PlayEvent& event = ahead_[i];
    if (event.begins_session || time_between(frame_logged_, event.event.timestamp) > farthest) break;
    if (event.event.channel == readings_) return i;
  }
  needed_.reset();
  return std::nullopt;
}

PlayEvent LockstepOrder::take(std::size_t i) {
  PlayEvent event = std::move(ahead_[i]);
  ahead_.erase(ahead_.begin() + static_cast<std::ptrdiff_t>(i));
  if (event.begins_session) covered_.reset();
  if (event.event.channel == readings_) covered_ = event.utime;
  if (!event.frame.empty()) {
    needed_ = *std::max_element(event.frame.begin(), event.frame.end());
    frame_logged_ = event.event.timestamp;
  }
  if (needed_ && covered_ && *covered_ >= *needed_) needed_.reset();
  return event;
}

bool LockstepOrder::pull() {
  auto event = source_();
  if (!event) return false;
  ahead_.push_back(std::move(*event));
  return true;
}

}  // namespace lcmslam
