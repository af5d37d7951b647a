#pragma once
// Stamps of a device that counts its own time, on this machine's clock.
//
// An image arrives later than it was taken by a delay that varies and is never negative:
//   arrival = device + offset + delay,
// so the least of arrival - device is the offset and the least delay. The least of the last ten to twenty
// seconds is taken: the two clocks drift apart by less than a millisecond in that time (50 ppm).

#include <cstdint>
#include <limits>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

class DeviceClock {
 public:
  /// This machine's time of what the device stamped `device` (us) and what arrived here at `arrival` (us).
  /// Later stamps give later times; one that is less than a second earlier (the other camera of a head) gives
  /// an earlier time. A device that begins to count anew, and a clock here that is set, are followed.
  Utime to_host(Utime device, Utime arrival);

  /// False: the device's stamps do not run as this machine's clock does (by more than 2 %), so they mean
  /// something else, and to_host() gives the arrival.
  bool believed() const { return believed_; }

 private:
  void begin(Utime device, Utime arrival);
  bool clock_was_set(Utime offset);
  void judge(Utime device, Utime arrival);

  static constexpr Utime none = std::numeric_limits<Utime>::max();
  bool begun_ = false, believed_ = true;
  Utime first_device_ = 0, first_arrival_ = 0;  // of what is judged
  Utime last_device_ = 0, last_ = 0;            // the latest stamp, and what was given for it
  Utime window_start_ = 0;                      // device's time
  Utime least_ = none, least_before_ = none;    // of arrival - device, in this window and the one before
  Utime last_offset_ = 0;
  int late_ = 0, doubts_ = 0;  // images in a row
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
