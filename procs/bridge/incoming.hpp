#pragma once
// What comes from outside, before anything of it reaches the bus: only channels that are allowed, only at
// their rate, only sound messages. Whoever sends anything else is counted.

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <lcmslam/bridge/channel_rule.hpp>
#include <lcmslam/bridge/token_bucket.hpp>
#include <lcmslam/bridge/topics.hpp>
#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/messages/any_message.hpp>
#include <lcmslam/messages/parts.hpp>

namespace lcmslam {

class Incoming {
 public:
  using Time = bridge::TokenBucket::Time;

  /// To a robot orders come 10 a second at most where the rule names no rate, and never from the broker's
  /// memory: an order is for now.
  Incoming(const std::vector<bridge::ChannelRule>& allowed, bridge::Side side);

  struct Message {
    std::string channel;
    Utime utime = 0;
    std::vector<std::uint8_t> bytes;
  };
  /// What is to go on the bus: nothing for what is refused, and for a piece of what is not yet whole. Beyond
  /// its rate the newest message of a channel waits for due(): the last word stands. A whole map that is
  /// older than what came of it before is left out.
  std::optional<Message> take(const std::string& channel, const std::uint8_t* data, std::size_t size,
                              bool kept, Time now);
  /// What has waited, and may go now. To be asked before take(), too: who waited longer goes first.
  std::vector<Message> due(Time now);

  enum class Refused { not_allowed, from_memory, too_big, too_often, malformed };
  static constexpr std::size_t reasons = 5;
  std::int64_t count(Refused why) const { return refused_[static_cast<std::size_t>(why)]; }
  std::int64_t refused() const;
  /// Messages of which pieces never came.
  std::int64_t incomplete() const { return assembler_.incomplete(); }
  /// Of the last message that was malformed.
  const std::string& last_error() const { return last_error_; }

 private:
  std::optional<Message> refuse(Refused why);
  std::size_t largest() const;  // bytes of a message, in pieces or not
  std::optional<Message> check(const std::string& channel, std::vector<std::uint8_t> bytes);
  bool is_overtaken(const AnyMessage& message, const std::vector<std::uint8_t>& bytes);
  std::optional<Message> join(const std::string& channel, const std::uint8_t* data, std::size_t size);

  struct Allowed {
    bridge::TokenBucket bucket;
    std::optional<Message> waiting = {};
    Time came{};
  };
  void wait(Allowed& rule, std::optional<Message> message, Time now);

  bridge::Side side_;
  std::map<std::string, Allowed> allowed_;  // by channel
  PartAssembler assembler_;
  std::map<std::pair<std::int64_t, std::string>, Utime> graphs_, landmarks_;  // newest, by sender and frame
  std::array<std::int64_t, reasons> refused_{};
  std::string last_error_;
};

}  // namespace lcmslam
