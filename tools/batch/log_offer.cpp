#include "tools/batch/log_offer.hpp"

#include <optional>

#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/messages/decode.hpp>
#include "tools/log/message_facts.hpp"
#include "tools/log/part_joiner.hpp"

namespace lcmslam {
namespace {

/// Of a message's pieces the first stands for it; nothing for the others.
std::optional<std::string> channel_of(const LogEventView& event) {
  if (!PartJoiner::is_piece(event)) return std::string(event.channel);
  try {
    const auto part = decode_message<part_t>(event.data, event.size);
    return part.part == 0 ? std::optional<std::string>(part.channel) : std::nullopt;
  } catch (const DecodeError&) {
    return std::nullopt;
  }
}

}  // namespace

std::string LogOffer::listed() const {
  std::string text;
  for (const auto& [channel, count] : messages) {
    text += (text.empty() ? "" : ", ") + channel;
    for (const auto& [type, channels] : by_type)
      if (channels.count(channel) > 0) text += " (" + type + ")";
  }
  return text.empty() ? "nothing" : text;
}

LogOffer read_offer(const std::filesystem::path& log, const LogSpan& span) {
  LogReader reader(log.string());
  LogOffer offer;
  std::optional<Utime> start;
  while (const auto event = reader.next_view()) {
    if (!start) start = event->timestamp;
    const double seconds = 1e-6 * static_cast<double>(time_between(*start, event->timestamp));
    const auto channel = channel_of(*event);
    if (!channel) continue;
    if (*channel == "CAMERA_CALIBRATION" && (span.is_before(seconds) || span.holds(seconds)))
      offer.calibrated = true;
    if (!span.holds(seconds)) continue;
    ++offer.messages[*channel];
    if (const MessageType* type = message_type(event->data, event->size); type != nullptr)
      offer.by_type[type->name].insert(*channel);
  }
  return offer;
}

}  // namespace lcmslam
