#include "procs/bridge/incoming.hpp"

#include <algorithm>
#include <numeric>

#include <lcmslam/command_t.hpp>
#include <lcmslam/graph_t.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/messages/decode.hpp>

namespace lcmslam {
namespace {

constexpr double usual_orders = 10;             // Hz
constexpr std::size_t largest_order = 100'000;  // bytes
constexpr std::size_t largest_other = 32 << 20;
constexpr std::size_t most_maps = 1000;
constexpr std::chrono::seconds longest_wait{
    1};  // of an order: where the rate is below 1 Hz it is too old then

}  // namespace

Incoming::Incoming(const std::vector<bridge::ChannelRule>& allowed, bridge::Side side) : side_(side) {
  for (const bridge::ChannelRule& rule : allowed) {
    const double rate = rule.rate > 0 || side == bridge::Side::operating ? rule.rate : usual_orders;
    allowed_.emplace(rule.channel, Allowed{bridge::TokenBucket(rate, std::max(2.0, rate))});
  }
}

std::optional<Incoming::Message> Incoming::take(const std::string& channel, const std::uint8_t* data,
                                                std::size_t size, bool kept, Time now) {
  const bool piece = is_part_channel(channel);
  const std::string whole = piece ? channel.substr(0, channel.size() - part_channel("").size()) : channel;
  const auto rule = allowed_.find(whole);
  if (rule == allowed_.end()) return refuse(Refused::not_allowed);
  if (kept && side_ == bridge::Side::robot) return refuse(Refused::from_memory);
  if (size > largest()) return refuse(Refused::too_big);
  if (size == 0 && side_ == bridge::Side::operating) return std::nullopt;  // what was kept there is no more
  try {
    std::optional<Message> message = piece ? join(whole, data, size) : check(whole, {data, data + size});
    if (!message || rule->second.bucket.try_take(1, now)) return message;  // a rate is of whole messages
    wait(rule->second, std::move(message), now);
    return std::nullopt;
  } catch (const DecodeError& error) {
    last_error_ = whole + ": " + error.what();
    return refuse(Refused::malformed);
  }
}

/// The message that this piece completes.
std::optional<Incoming::Message> Incoming::join(const std::string& channel, const std::uint8_t* data,
                                                std::size_t size) {
  const auto part = decode_message<part_t>(data, size);
  if (part.channel != channel) throw DecodeError("part_t of another channel");
  if (static_cast<std::size_t>(std::max(part.total_size, 0)) > largest()) return refuse(Refused::too_big);
  auto joined = assembler_.add(part);
  if (!joined) return std::nullopt;
  return check(channel, std::move(joined->bytes));
}

std::size_t Incoming::largest() const {
  return side_ == bridge::Side::robot ? largest_order : largest_other;
}

void Incoming::wait(Allowed& rule, std::optional<Message> message, Time now) {
  if (rule.waiting) refuse(Refused::too_often);
  rule.waiting = std::move(message);
  rule.came = now;
}

std::vector<Incoming::Message> Incoming::due(Time now) {
  std::vector<Message> messages;
  for (auto& [channel, rule] : allowed_) {
    if (!rule.waiting) continue;
    if (side_ == bridge::Side::robot && now - rule.came > longest_wait)
      refuse(Refused::too_often);
    else if (rule.bucket.try_take(1, now))
      messages.push_back(std::move(*rule.waiting));
    else
      continue;
    rule.waiting.reset();
  }
  return messages;
}

std::optional<Incoming::Message> Incoming::check(const std::string& channel,
                                                 std::vector<std::uint8_t> bytes) {
  const AnyMessage message = identify(bytes.data(), bytes.size());
  // The map goes out anyhow; all of it on the bus again, as often as somebody far away likes, would take the
  // robot's processors.
  if (side_ == bridge::Side::robot && channel == "COMMAND" &&
      decode_message<command_t>(bytes.data(), bytes.size()).name == "resend")
    return refuse(Refused::not_allowed);
  if (side_ == bridge::Side::operating && is_overtaken(message, bytes)) return std::nullopt;
  return Message{channel, message.utime, std::move(bytes)};
}

/// What a broker keeps may be of long ago: of a former run of the robot's bridge, or of before this one lost
/// its connection. A map that was newer must not go back to that; its changes would no longer fit.
bool Incoming::is_overtaken(const AnyMessage& message, const std::vector<std::uint8_t>& bytes) {
  const auto overtaken = [&](auto& maps, const std::string& frame, bool whole) {
    if (maps.size() >= most_maps) maps.clear();
    Utime& newest = maps.try_emplace({message.origin.sender, frame}, message.utime).first->second;
    if (whole && message.utime < newest) return true;
    newest = std::max(newest, message.utime);
    return false;
  };
  const std::string& type = message.type->name;
  if (type == "graph_t") {
    const auto graph = decode_message<graph_t>(bytes.data(), bytes.size());
    return overtaken(graphs_, graph.frame, graph.change == 0);
  }
  if (type == "landmarks_t") {
    const auto landmarks = decode_message<landmarks_t>(bytes.data(), bytes.size());
    return overtaken(landmarks_, landmarks.frame, landmarks.base_revision == 0);
  }
  return false;
}

std::optional<Incoming::Message> Incoming::refuse(Refused why) {
  ++refused_[static_cast<std::size_t>(why)];
  return std::nullopt;
}

std::int64_t Incoming::refused() const {
  return std::accumulate(refused_.begin(), refused_.end(), std::int64_t{0});
}

}  // namespace lcmslam
