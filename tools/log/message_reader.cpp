#include "tools/log/message_reader.hpp"

#include <lcmslam/messages/decode.hpp>
#include "tools/log/message_facts.hpp"

namespace lcmslam {

namespace {

/// Of a log of several robots: whether the channel is this one's, whose name is taken away.
template <class Text>
bool strip(Text& channel, const std::string& prefix) {
  if (channel.substr(0, prefix.size()) != prefix) return false;
  channel = channel.substr(prefix.size());
  return true;
}

std::string prefix_of(const std::string& robot) {
  return robot.empty() ? "" : robot + "/";
}

/// None where the piece is damaged.
std::optional<std::string> channel_of_piece(const LogEventView& piece) {
  try {
    return decode_message<part_t>(piece.data, piece.size).channel;
  } catch (const DecodeError&) {
    return std::nullopt;
  }
}

}  // namespace

MessageReader::MessageReader(const std::string& file, const std::string& robot, bool whole)
    : reader_(file, whole ? WholenessCheck(check_message) : nullptr), prefix_(prefix_of(robot)) {}

std::optional<LogEventView> MessageReader::next() {
  while (auto event = reader_.next_view()) {
    if (!strip(event->channel, prefix_)) continue;
    ++read_;
    if (!PartJoiner::is_piece(*event)) return event;
    try {
      auto whole = joiner_.add(*event);
      if (!whole) continue;
      whole_ = std::move(*whole);
      strip(whole_.channel, prefix_);
      ++joined_;
      return LogEventView{whole_.number,      whole_.timestamp,   whole_.channel,
                          whole_.data.data(), whole_.data.size(), event->offset};
    } catch (const DecodeError& error) {
      bad_pieces_.push_back({event->offset, reader_.position(), error.what(), 1});
    }
  }
  return std::nullopt;
}

std::int64_t MessageReader::incomplete() const {
  std::int64_t sum = 0;
  for (const auto& [channel, count] : joiner_.counts()) sum += count.incomplete;
  return sum;
}

std::vector<LogDamage> MessageReader::damages() const {
  std::vector<LogDamage> all = bad_pieces_;
  all.insert(all.end(), reader_.damages().begin(), reader_.damages().end());
  return all;
}

LogContents scan_log(const std::string& file, const std::string& robot) {
  const std::string prefix = prefix_of(robot);
  LogReader reader(file);
  LogContents contents;
  bool first = true;
  while (const auto event = reader.next_view()) {
    if (first) contents.first = event->timestamp;
    first = false;
    std::string channel(event->channel);
    if (!strip(channel, prefix)) continue;
    if (PartJoiner::is_piece(*event)) {
      const auto whole = channel_of_piece(*event);
      if (!whole) continue;
      channel = *whole;
      strip(channel, prefix);
    }
    contents.channels.insert(channel);
  }
  if (first) throw std::runtime_error(file + ": no event in it is whole");
  return contents;
}

}  // namespace lcmslam
