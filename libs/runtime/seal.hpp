#pragma once
// Messages that only who knows the bus's key can make: a keyed hash (BLAKE2b of libsodium, 16 bytes) over
// channel, message, sender and time, in a trailer (log/seal_trailer.hpp). It proves where a message comes
// from; it hides nothing.

#include <chrono>
#include <map>
#include <optional>

#include <lcmslam/runtime/bus_key.hpp>
#include <lcmslam/runtime/bus_message.hpp>
#include <lcmslam/runtime/refusals.hpp>

namespace lcmslam {

using WallTime = std::chrono::system_clock::time_point;

class Sealer {
 public:
  /// `sender` marks this process; a new one after each start.
  Sealer(const BusKey& key, std::int64_t sender) : key_(key), sender_(sender) {}

  /// Appends the trailer. Times grow even where the clock does not; where it is set back by more than 15 s
  /// they begin anew, as those of another process.
  void seal(const std::string& channel, std::vector<std::uint8_t>& message, WallTime now);

 private:
  BusKey key_;
  std::int64_t sender_;
  std::int64_t last_ = 0;  // us
};

class SealChecker {
 public:
  explicit SealChecker(const BusKey& key) : key_(key) {}

  /// Takes the trailer off, or says why the message is refused: `unsealed`, `replayed` for what the sender
  /// sealed before its last message on this channel that was taken, or `other_time` for what it sealed 30 s
  /// and more away from `now`: the machines' clocks must agree to that.
  std::optional<Refusal> open(BusMessage& message, WallTime now);
  /// s that the last message of another time was old; negative: its sender's clock is ahead.
  double last_age() const { return last_age_; }

 private:
  BusKey key_;
  double last_age_ = 0;
  // Only messages with a right seal come here, and those of 30 s ago go, so that this cannot grow by
  // strangers.
  std::map<std::pair<std::int64_t, std::string>, std::int64_t> last_;  // us, by sender and channel
};

}  // namespace lcmslam
