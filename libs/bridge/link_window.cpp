#include <lcmslam/bridge/link_window.hpp>

#include <algorithm>

namespace lcmslam::bridge {
namespace {

double seconds(Time from, Time to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

void LinkWindow::Smallest::add(Time at, double time) {
  while (!candidates_.empty() && candidates_.back().second >= time) candidates_.pop_back();
  candidates_.emplace_back(at, time);
  while (seconds(candidates_.front().first, at) > memory_) candidates_.pop_front();
}

void LinkWindow::sent(std::size_t bytes) {
  in_flight_ += bytes;
  ++messages_;
}

void LinkWindow::acknowledged(std::size_t bytes, Time sent, Time now) {
  const bool full = 2 * in_flight_ > window_;
  in_flight_ -= std::min(bytes, in_flight_);
  messages_ -= messages_ > 0 ? 1 : 0;

  const double time = seconds(sent, now);
  own_.add(now, time);
  newest_.add(now, time);
  if (full && time - own_() <= delay_)
    window_ = std::min(window_ + (searching_ ? bytes : bytes * bytes / window_ + 1), most);

  if (shrunk_ == Time{}) shrunk_ = now;
  const bool queue = newest_() - own_() > delay_;
  const double since = seconds(shrunk_, now);  // what is under way now was sent after that
  if (since > patience || (queue && since > std::max(time, lately))) {
    const double without_queue = static_cast<double>(window_) * own_() / newest_();
    window_ = std::max(static_cast<std::size_t>(0.9 * without_queue), least);
    searching_ = searching_ && !queue;
    shrunk_ = now;
  }
}

void LinkWindow::reset() {
  *this = LinkWindow(delay_);
}

}  // namespace lcmslam::bridge
