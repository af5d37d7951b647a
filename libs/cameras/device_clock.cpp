#include <lcmslam/cameras/device_clock.hpp>

#include <algorithm>
#include <cstdlib>

namespace lcmslam {
namespace {

constexpr Utime window = 10'000'000;         // us
constexpr Utime began_anew = 1'000'000;      // us back
constexpr Utime largest_delay = 1'000'000;   // us
constexpr int believed_in_a_row = 5;         // images; a process that slept finds fewer in its buffers
constexpr Utime least_judged = 2'000'000;    // us of device time, after which delays are small beside it
constexpr double largest_rate_error = 0.02;  // crystals err by 1e-4, a wrong unit by far more

}  // namespace

Utime DeviceClock::to_host(Utime device, Utime arrival) {
  if (!begun_ || device < last_device_ - began_anew) begin(device, arrival);
  if (clock_was_set(arrival - device)) begin(device, arrival);
  judge(device, arrival);
  const bool later = device > last_device_;
  last_device_ = std::max(last_device_, device);
  if (!believed_) return arrival;

  if (device - window_start_ > window) {
    window_start_ = device;
    least_before_ = least_;
    least_ = none;
  }
  least_ = std::min(least_, arrival - device);
  Utime host = device + std::min(least_, least_before_);
  const bool clock_set_back = host < last_ - largest_delay;
  if (later && !clock_set_back) host = std::max(host, last_ + 1);
  if (later || clock_set_back) last_ = host;
  return host;
}

void DeviceClock::begin(Utime device, Utime arrival) {
  begun_ = true;
  first_device_ = window_start_ = last_device_ = device;
  first_arrival_ = arrival;
  least_ = least_before_ = none;
  last_offset_ = arrival - device;
  late_ = doubts_ = 0;
}

/// A jump that stays. (The other way the least offset follows by itself.)
bool DeviceClock::clock_was_set(Utime offset) {
  const bool jumps = offset - last_offset_ > largest_delay;
  const bool stays = late_ > 0 && offset - std::min(least_, least_before_) > largest_delay;
  late_ = jumps || stays ? late_ + 1 : 0;
  last_offset_ = offset;
  return late_ >= believed_in_a_row;
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
