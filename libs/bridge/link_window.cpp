#include <lcmslam/bridge/link_window.hpp>

#include <algorithm>

namespace lcmslam::bridge {
namespace {

double seconds(Time from, Time to) {
  return std::chrono::duration<double>(to - from).count();
}

constexpr double memory = 30;  // s in which the link's own time is looked for

}  // namespace

void LinkWindow::sent(std::size_t bytes) {
  in_flight_ += bytes;
  ++messages_;
}

void LinkWindow::acknowledged(std::size_t bytes, Time sent, Time now) {
  const bool full = 2 * in_flight_ > window_;
  in_flight_ -= std::min(bytes, in_flight_);
  messages_ -= messages_ > 0 ? 1 : 0;

  const double time = seconds(sent, now);
  while (!fastest_.empty() && fastest_.back().time >= time) fastest_.pop_back();
  fastest_.push_back({now, time});
  while (seconds(fastest_.front().at, now) > memory) fastest_.pop_front();

  const double queued = time - fastest_.front().time;
  if (queued <= delay_) {
    const bool searching = shrunk_ == Time{};
    if (full) window_ = std::min(window_ + (searching ? bytes : bytes * bytes / window_ + 1), most);
  } else if (seconds(shrunk_, now) > time) {  // what is under way now was sent before the last time
    const double without_queue = static_cast<double>(window_) * fastest_.front().time / time;
    window_ = std::max(static_cast<std::size_t>(0.9 * without_queue), least);
    shrunk_ = now;
  }
}

void LinkWindow::reset() {
  *this = LinkWindow(delay_);
}

}  // namespace lcmslam::bridge
