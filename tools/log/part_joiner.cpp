#include "tools/log/part_joiner.hpp"

#include <lcmslam/messages/decode.hpp>
#include "tools/log/message_facts.hpp"

namespace lcmslam {

bool PartJoiner::is_piece(const LogEventView& event) {
  static const auto part = static_cast<std::uint64_t>(part_t::getHash());
  return is_part_channel(std::string(event.channel)) && fingerprint(event.data, event.size) == part;
}

std::optional<LogEvent> PartJoiner::add(const LogEventView& piece) {
  const auto part = decode_message<part_t>(piece.data, piece.size);
  auto whole = assembler_.add(part);
  Channel& channel = channels_[part.channel];
  ++channel.pieces;
  channel.begun.emplace(part.sender, part.message);
  if (!whole) return std::nullopt;
  channel.whole.emplace(part.sender, part.message);
  return LogEvent{piece.number, piece.timestamp, std::move(whole->channel), std::move(whole->bytes)};
}

std::map<std::string, PartJoiner::Count> PartJoiner::counts() const {
  std::map<std::string, Count> result;
  for (const auto& [name, channel] : channels_) {
    const auto whole = static_cast<std::int64_t>(channel.whole.size());
    result[name] = {channel.pieces, whole, static_cast<std::int64_t>(channel.begun.size()) - whole};
  }
  return result;
}

}  // namespace lcmslam
