#pragma once
// Stamps of a device that counts its own time, on this machine's clock.
//
// An image arrives later than it was taken by a delay that varies and is never negative:
//   arrival = device + offset + delay,
// so the least of arrival - device is the offset and the least delay. The least of the last ten to twenty
// seconds is taken: the two clocks drift apart by less than a millisecond in that time (50 ppm).
//
// Arrivals are measured by a clock that nobody sets, which is carried to the wall clock as both stand then: a
// wall clock that is set moves the stamps at once, and is no delay.

#include <cstdint>
#include <limits>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// One moment by this machine's clocks (us).
struct HostTime {
  Utime wall = 0;    ///< since 1970; somebody may set it
  Utime steady = 0;  ///< since some start; nobody sets it
};

class DeviceClock {
 public:
  /// This machine's wall clock (us) when the device took what it stamped `device` (us).
  /// Later stamps give later times; one that is less than a second earlier (the other camera of a head) gives
  /// an earlier time. A device that begins to count anew is followed. So is a wall clock that is set:
  /// forward, or back by more than a second, at once; back by less, stamps go at a quarter of their pace
  /// until it has come after them (1.4 s at most), as time that goes back by so little would be refused.
  Utime to_host(Utime device, const HostTime& arrival);

  /// False: the device's stamps do not run as this machine's clocks do (by more than 2 %), so they mean
  /// something else, and to_host() gives the arrival.
  bool believed() const { return believed_; }

 private:
  void begin(Utime device, Utime arrival);
  bool device_stood_still(Utime offset);
  void judge(Utime device, Utime arrival);
  Utime steady_offset(Utime device, Utime arrival);
  void follow(Utime offset, Utime passed);

  static constexpr Utime none = std::numeric_limits<Utime>::max();
  bool begun_ = false, believed_ = true;
  Utime first_device_ = 0, first_arrival_ = 0;  // of what is judged; all arrivals are steady
  Utime last_device_ = 0;                       // the latest stamp
  Utime window_start_ = 0;                      // device's time
  Utime least_ = none, least_before_ = none;    // of arrival - device, in this window and the one before
  Utime last_offset_ = 0;                       // arrival - device
  Utime wall_ = 0;                              // wall - steady
  Utime wall_offset_ = none;                    // what is added to the device's stamps
  int late_ = 0, doubts_ = 0;                   // images in a row
};

/// A 32-bit counter that begins anew at 2^32, as one that goes on.
class UnrolledCounter {
 public:
  std::int64_t operator()(std::uint32_t count);

 private:
  bool begun_ = false;
  std::uint32_t last_ = 0;
  std::int64_t value_ = 0;
};

}  // namespace lcmslam
