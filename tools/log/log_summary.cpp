#include "tools/log/log_summary.hpp"

#include <algorithm>

#include "tools/log/log_session.hpp"
#include "tools/log/message_facts.hpp"

namespace lcmslam {
namespace {

constexpr std::size_t most_types = 8;  // of a channel; more are garbage

/// Follows one channel's times.
struct ChannelTimes {
  std::size_t session = 0;
  Utime last = 0;
  std::int64_t intervals = 0;
  double seconds = 0;
};

class Summariser {
 public:
  explicit Summariser(LogSummary& summary) : summary_(summary) {}

  void add(const LogEventView& event) {
    ++summary_.events;
    follow_session(event);
    ChannelSummary& channel = summary_.channels[std::string(event.channel)];
    count(channel, event);
    follow_times(channel, times_[std::string(event.channel)], event);
    follow_numbers(channel, event);
    if (!PartJoiner::is_piece(event)) return;
    try {
      joiner_.add(event);
    } catch (const DecodeError&) {  // `log check` tells which
    }
  }

  void finish() {
    for (auto& [name, channel] : summary_.channels) {
      const ChannelTimes& times = times_[name];
      if (times.seconds > 0) channel.rate = static_cast<double>(times.intervals) / times.seconds;
    }
    summary_.in_pieces = joiner_.counts();
  }

 private:
  void follow_session(const LogEventView& event) {
    if (tracker_.begins(event)) {
      summary_.sessions.push_back({event.offset, event.timestamp, event.timestamp, 0});
    } else if (event.timestamp < last_) {
      ++summary_.jumps_back;
      summary_.largest_jump_back = std::max(summary_.largest_jump_back, time_between(event.timestamp, last_));
    }
    last_ = event.timestamp;
    SessionSummary& session = summary_.sessions.back();
    session.first = std::min(session.first, event.timestamp);
    session.last = std::max(session.last, event.timestamp);
    ++session.events;
  }

  static void count(ChannelSummary& channel, const LogEventView& event) {
    const auto size = static_cast<std::int64_t>(event.size);
    ++channel.count;
    channel.bytes += size;
    channel.largest = std::max(channel.largest, size);
    const auto type = fingerprint(event.data, event.size);
    if (!type)
      ++channel.untyped;
    else if (channel.types.count(*type) > 0 || channel.types.size() < most_types)
      ++channel.types[*type];
    else
      ++channel.other_types;
  }

  void follow_times(ChannelSummary& channel, ChannelTimes& times, const LogEventView& event) const {
    if (times.session == summary_.sessions.size()) {
      const Utime interval = time_between(times.last, event.timestamp);
      channel.jumps_back += interval < 0 ? 1 : 0;
      channel.largest_gap = std::max(channel.largest_gap, interval);
      times.seconds += 1e-6 * static_cast<double>(interval);
      ++times.intervals;
    }
    times.session = summary_.sessions.size();
    times.last = event.timestamp;
  }

  static void follow_numbers(ChannelSummary& channel, const LogEventView& event) {
    const Origin origin = message_origin(event.data, event.size);
    if (origin.seq < 0) return;
    InputCount& sender = channel.senders.of(origin.sender);
    ++sender.received;
    sender.follow(origin.seq, 0, message_utime(event.data, event.size).value_or(0));
  }

  LogSummary& summary_;
  SessionTracker tracker_;
  Utime last_ = 0;
  std::map<std::string, ChannelTimes> times_;
  PartJoiner joiner_;
};

}  // namespace

LogSummary summarise_log(const std::string& file) {
  LogReader reader(file, check_message);
  LogSummary summary;
  summary.file = file;
  summary.size = reader.size();
  Summariser summariser(summary);
  while (const auto event = reader.next_view()) summariser.add(*event);
  summariser.finish();
  summary.damages = reader.damages();
  return summary;
}

}  // namespace lcmslam
