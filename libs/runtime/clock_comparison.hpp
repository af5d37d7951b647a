#pragma once
// How far the clocks of several hosts are apart, as NTP measures it (RFC 5905, section 8): each host says
// from time to time when it spoke and when it last heard the others. Of a message there and one back,
//   offset = ((received there - sent here) + (sent there - received here)) / 2,
// wrong by half of what the two ways differ, at most by half of the time round; so the exchange that was
// fastest of the last ones is believed.

#include <deque>
#include <map>
#include <optional>
#include <string>

#include <lcmslam/command_t.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// On this channel hosts speak of their clocks: command_t of name "clock", target: the speaker's host, utime:
/// its clock; keys: senders that it has heard, values: "SENT HEARD", us by their clock and by its own.
constexpr const char* clock_channel = "HOST_CLOCK";

class ClockComparison {
 public:
  ClockComparison(std::string host, std::int64_t sender) : host_(std::move(host)), sender_(sender) {}

  /// What this host says now; `now`: us of its clock.
  command_t tell(Utime now) const;
  /// What another said, when it came. Anything else is left out.
  void hear(const command_t& message, Utime now);

  struct Offset {
    double offset = 0;  ///< s that the other's clock is ahead of this one's
    double error = 0;   ///< s, at most
  };
  /// By host; those that were silent for 10 s are left out.
  std::map<std::string, Offset> offsets(Utime now) const;

 private:
  struct Exchange {
    double offset, round;  // s
  };
  struct Host {
    std::string name;
    Utime sent = 0, heard = 0;
    std::deque<Exchange> exchanges;
  };
  std::string host_;
  std::int64_t sender_;
  std::map<std::int64_t, Host> hosts_;  // by sender
};

}  // namespace lcmslam
