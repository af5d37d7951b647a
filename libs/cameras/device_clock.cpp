#include <lcmslam/cameras/device_clock.hpp>

#include <algorithm>
#include <cstdlib>

namespace lcmslam {
namespace {

constexpr Utime window = 10'000'000;         // us
constexpr Utime began_anew = 1'000'000;      // us back, for all who read stamps (ImagePairs, WatchedCamera)
constexpr Utime readings_differ = 1'000;     // us at most, from reading to reading, unless a clock is set
constexpr Utime slowest_pace = 4;            // a quarter, of stamps that wait for a clock that was set back
constexpr Utime largest_delay = 1'000'000;   // us
constexpr int believed_in_a_row = 5;         // images; a process that slept finds fewer in its buffers
constexpr Utime least_judged = 2'000'000;    // us of device time, after which delays are small beside it
constexpr double largest_rate_error = 0.02;  // crystals err by 1e-4, a wrong unit by far more

}  // namespace

Utime DeviceClock::to_host(Utime device, const HostTime& arrival) {
  if (!begun_ || device < last_device_ - began_anew || device_stood_still(arrival.steady - device))
    begin(device, arrival.steady);
  judge(device, arrival.steady);
  if (const Utime wall = arrival.wall - arrival.steady; std::abs(wall - wall_) > readings_differ)
    wall_ = wall;
  const Utime offset = steady_offset(device, arrival.steady) + wall_;
  if (believed_)
    follow(offset, std::max<Utime>(device - last_device_, 0));
  else
    wall_offset_ = arrival.wall - device;
  last_device_ = std::max(last_device_, device);
  return device + wall_offset_;
}

void DeviceClock::begin(Utime device, Utime arrival) {
  begun_ = true;
  first_device_ = window_start_ = last_device_ = device;
  first_arrival_ = arrival;
  least_ = least_before_ = wall_offset_ = none;
  last_offset_ = arrival - device;
  late_ = doubts_ = 0;
}

/// A jump that stays. (The other way the least offset follows by itself.)
bool DeviceClock::device_stood_still(Utime offset) {
  const bool jumps = offset - last_offset_ > largest_delay;
  const bool stays = late_ > 0 && offset - std::min(least_, least_before_) > largest_delay;
  late_ = jumps || stays ? late_ + 1 : 0;
  last_offset_ = offset;
  return late_ >= believed_in_a_row;
}

/// Added to a stamp it gives the steady clock.
Utime DeviceClock::steady_offset(Utime device, Utime arrival) {
  if (device - window_start_ > window) {
    window_start_ = device;
    least_before_ = least_;
    least_ = none;
  }
  least_ = std::min(least_, arrival - device);
  return std::min(least_, least_before_);
}

/// Takes `offset`, so that stamps stay in order unless time begins anew; `passed`: us since the last stamp.
void DeviceClock::follow(Utime offset, Utime passed) {
  const bool begins_anew = wall_offset_ == none || offset < wall_offset_ - passed - began_anew;
  wall_offset_ = begins_anew ? offset : std::max(offset, wall_offset_ - passed + passed / slowest_pace);
}

/// Whether as much time passed by the device as by us, but for half a second of delays.
void DeviceClock::judge(Utime device, Utime arrival) {
  const Utime counted = device - first_device_, passed = arrival - first_arrival_;
  if (std::max(counted, passed) < least_judged) return;
  const auto tolerated = static_cast<Utime>(largest_rate_error * static_cast<double>(passed)) + 500'000;
  doubts_ = std::abs(counted - passed) > tolerated ? doubts_ + 1 : 0;
  believed_ = doubts_ < believed_in_a_row;
}

std::int64_t UnrolledCounter::operator()(std::uint32_t count) {
  if (begun_)
    value_ += static_cast<std::int32_t>(count - last_);
  else
    value_ = count;
  begun_ = true;
  last_ = count;
  return value_;
}

}  // namespace lcmslam
