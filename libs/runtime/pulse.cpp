#include <lcmslam/runtime/pulse.hpp>

#include <algorithm>

namespace lcmslam {
namespace {

constexpr int enough = 10;            // beats
constexpr double shortest = 0.5;      // s: a process that works may hold its answers back for so long
constexpr double periods = 5;         // missed ones
constexpr double share_of_new = 0.1;  // of each beat in the mean

double seconds(Pulse::Time::duration time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

// The time without beats says nothing of how often they come, until each one comes so late.
void Pulse::beat(Time now) {
  late_ = stopped(now) ? late_ + 1 : 0;
  if (late_ == enough) *this = Pulse();
  if (beats_ > 0 && !stopped(now)) {
    const double share = std::max(share_of_new, 1.0 / beats_);
    period_ += share * (seconds(now - last_) - period_);
  }
  last_ = now;
  beats_ = std::min(beats_ + 1, enough);
}

bool Pulse::stopped(Time now) const {
  return beats_ >= enough && seconds(now - last_) > std::max(shortest, periods * period_);
}

}  // namespace lcmslam
