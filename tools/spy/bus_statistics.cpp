#include "tools/spy/bus_statistics.hpp"

#include <cinttypes>
#include <cstdio>

#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/print_message.hpp>
#include <lcmslam/messages/wire_reader.hpp>
#include <lcmslam/runtime/bus_robot.hpp>

namespace lcmslam {
namespace {

// Garbage must not grow the tables for ever.
constexpr std::size_t most_channels = 1000;
constexpr std::size_t most_types = 64;

/// Enough to read the numbering of every type.
MessageLimits header_limits() {
  MessageLimits limits;
  limits.elements = 0;
  limits.records = 16;
  limits.text = 16;
  limits.bytes = 8;
  return limits;
}

Utime utime_of(const MessageValue& message) {
  const MessageValue* utime = member(message, "utime");
  return utime == nullptr ? 0 : utime->integer;
}

std::string type_name(std::uint64_t fingerprint) {
  if (const MessageType* type = MessageType::find(fingerprint)) return display_name(*type);
  char text[32];
  std::snprintf(text, sizeof text, "?? %016" PRIx64, fingerprint);
  return text;
}

}  // namespace

std::uint64_t message_fingerprint(const std::uint8_t* data, std::size_t size) {
  if (size < 8) throw DecodeError(std::to_string(size) + " bytes are too few for an LCM message");
  return static_cast<std::uint64_t>(WireReader(data, size).integer(8, "fingerprint"));
}

void BusStatistics::follow(SenderCounts& senders, const Origin& origin, Utime utime,
                           std::int64_t known_missing) {
  if (origin.seq >= 0) senders.of(origin.sender).follow(origin.seq, known_missing, utime);
}

BusStatistics::Channel* BusStatistics::find(const std::string& name) {
  const auto found = channels_.find(name);
  if (found != channels_.end()) return &found->second;
  if (channels_.size() >= most_channels) {
    ++left_out_;
    return nullptr;
  }
  Channel& channel = channels_.emplace(name, Channel(window_)).first->second;
  channel.report.channel = name;
  channel.report.type = "-";
  return &channel;
}

void BusStatistics::add(const std::string& name, const std::uint8_t* data, std::size_t size, double time) {
  static const MessageType* const part_type = MessageType::find("part_t");
  if (is_part_channel(name)) try {
      if (message_fingerprint(data, size) == part_type->fingerprint) {
        auto part = decode_message<part_t>(data, size);
        if (part_channel(part.channel) != name) part.channel = without_robot(part.channel);
        if (part_channel(part.channel) != name) throw DecodeError("part_t: of channel " + part.channel);
        if (Channel* channel = find(part.channel)) count_piece(*channel, part, time);
        return;
      }
    } catch (const DecodeError&) {
      // Shown as what it is: a message of its own that does not decode.
    }
  if (Channel* channel = find(name)) count(*channel, data, size, time);
}

void BusStatistics::count_piece(Channel& channel, const part_t& part, double time) {
  ++channel.report.pieces;
  channel.last_time = time;
  follow(channel.piece_senders, origin(part), part.utime, 0);
  try {
    const auto whole = channel.assembler.add(part);
    if (whole) count(channel, whole->bytes.data(), whole->bytes.size(), time);
  } catch (const DecodeError& error) {
    fail(channel, error.what());
  }
}

void BusStatistics::count(Channel& channel, const std::uint8_t* data, std::size_t size, double time) {
  ++channel.report.count;
  channel.report.largest = std::max(channel.report.largest, size);
  channel.rate.add(time, size);
  channel.last_time = time;
  try {
    look_at(channel, data, size);
  } catch (const DecodeError& error) {
    fail(channel, error.what());
    ++channel.unread;
  }
}

void BusStatistics::look_at(Channel& channel, const std::uint8_t* data, std::size_t size) {
  const std::uint64_t fingerprint = message_fingerprint(data, size);
  if (channel.fingerprints.size() < most_types) channel.fingerprints.insert(fingerprint);
  channel.report.type = type_name(fingerprint);
  const MessageType* type = MessageType::find(fingerprint);
  if (type == nullptr) return;
  const MessageValue message = read_message(*type, data, size, header_limits());
  follow(channel.senders, origin(message), utime_of(message), channel.unread);
  channel.unread = 0;
}

void BusStatistics::fail(Channel& channel, const std::string& error) {
  ++channel.report.decode_errors;
  channel.report.last_error = error;
}

std::vector<ChannelReport> BusStatistics::channels(double now) const {
  std::vector<ChannelReport> reports;
  for (const auto& [name, channel] : channels_) {
    ChannelReport report = channel.report;
    report.rate = channel.rate.at(now);
    report.types = channel.fingerprints.size();
    report.senders = channel.senders.known().size();
    const InputCount sum = channel.senders.total();
    report.lost = sum.lost;
    report.duplicates = sum.duplicates;
    report.reordered = sum.reordered;
    report.age = now - channel.last_time;
    report.lost_pieces = channel.piece_senders.total().lost;
    report.incomplete = channel.assembler.incomplete();
    reports.push_back(std::move(report));
  }
  return reports;
}

}  // namespace lcmslam
