#include <lcmslam/runtime/processor_watch.hpp>

namespace lcmslam {
namespace {

constexpr std::chrono::milliseconds window{500};
constexpr double notable = 0.2;  // s in a window: less makes nothing late
constexpr double over = 0.1;     // s, in which it has ended

}  // namespace

void ProcessorWatch::look(const ThreadTime& so_far, Time now) {
  looks_.push_back({now, so_far});
  while (looks_.size() > 2 && looks_[1].at <= now - window) looks_.pop_front();
  if (looks_.front().at > now - window) return;
  const double ran = so_far.ran - looks_.front().time.ran;
  const double waited = so_far.waited - looks_.front().time.waited;
  const bool starved = waited > (starved_ ? over : notable) && waited > ran;
  stretches_ += starved && !starved_ ? 1 : 0;
  starved_ = starved;
}

}  // namespace lcmslam
