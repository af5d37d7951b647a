#include "tools/log/log_check.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <map>
#include <optional>

#include <lcmslam/messages/print_message.hpp>
#include "tools/log/content_check.hpp"
#include "tools/log/log_session.hpp"
#include "tools/log/message_facts.hpp"
#include "tools/log/part_joiner.hpp"

namespace lcmslam {
namespace {

/// us; a message's utime may drift against the log's clock, and log time may jitter, but not that fast.
constexpr Utime largest_step = 10'000'000;
constexpr Utime largest_jitter = 100'000;  // us, by which lcm-logger may mix up the order of two senders

double seconds(Utime utime) {
  return 1e-6 * static_cast<double>(utime);
}

class Checker {
 public:
  Checker(LogCheck& check, const KnownTypes& types) : check_(check), types_(types) {}

  /// `after_damage`: events may be missing before this one; that has been reported.
  void add(const LogEventView& event, bool after_damage) {
    ++check_.events;
    if (sessions_.begins(event)) {
      ++check_.sessions;
      clocks_.clear();
    } else {
      check_order(event, after_damage);
    }
    last_ = event;
    if (std::any_of(event.channel.begin(), event.channel.end(), [](char c) { return c >= 0 && c < ' '; }))
      found(event, "control characters in the channel's name");
    const MessageType* type = types_.of(event.data, event.size);
    if (type == nullptr) {
      ++check_.unknown_types;
      check_.unknown_channels.emplace(event.channel);
    }
    check_utime(event, type);
    check_content(event, event.channel, event.data, event.size);
    if (PartJoiner::is_piece(event)) join(event);
  }

  void finish() {
    for (const auto& [channel, count] : joiner_.counts())
      if (count.incomplete > 0)
        check_.findings.push_back(
            {-1, 0, channel, fmt::format("{} messages in pieces are incomplete", count.incomplete)});
  }

 private:
  void found(const LogEventView& event, const std::string& text) {
    check_.findings.push_back({event.number, event.offset, std::string(event.channel), text});
  }

  void check_order(const LogEventView& event, bool after_damage) {
    if (event.timestamp < last_.timestamp) {
      const Utime back = time_between(event.timestamp, last_.timestamp);
      if (back > largest_jitter) {
        found(event, fmt::format("logged {:.6f} s before the event before it", seconds(back)));
      } else {
        ++check_.jittered;
        check_.largest_jitter = std::max(check_.largest_jitter, back);
      }
    }
    if (!after_damage && (event.number == INT64_MIN || event.number - 1 != last_.number))
      found(event, fmt::format("follows event number {}", last_.number));
  }

  void check_utime(const LogEventView& event, const MessageType* type) {
    const auto utime = message_utime_of(type, event.data, event.size);
    if (!utime || *utime == 0) return;  // 0: not known when it was sent
    constexpr Utime any_time = 1LL << 60;
    if (*utime < 0 || *utime > any_time || event.timestamp < 0 || event.timestamp > any_time)
      return found(event, fmt::format("utime {} or log time {} is no time", *utime, event.timestamp));
    const Utime offset = *utime - event.timestamp;
    const auto [clock, first] = clocks_.emplace(event.channel, offset);
    const Utime step = offset - clock->second;
    clock->second = offset;
    if (!first && std::abs(step) > largest_step)
      found(event, fmt::format("utime jumps by {:.3f} s against the log's time", seconds(step)));
  }

  void check_content(const LogEventView& event, std::string_view channel, const std::uint8_t* data,
                     std::size_t size) {
    const std::string problem = content_.problem(channel, data, size);
    if (!problem.empty()) found(event, "would be refused: " + problem);
  }

  void join(const LogEventView& piece) {
    try {
      const auto whole = joiner_.add(piece);
      if (!whole) return;
      const std::uint8_t* data = whole->data.data();
      const std::size_t size = whole->data.size();
      if (check_message_of(types_.of(data, size), data, size) == Wholeness::damaged)
        found(piece, "the message of these pieces is not what its type says");
      else
        check_content(piece, whole->channel, data, size);
    } catch (const DecodeError& error) {
      found(piece, error.what());
    }
  }

  LogCheck& check_;
  const KnownTypes& types_;
  SessionTracker sessions_;
  LogEventView last_;
  std::map<std::string_view, Utime> clocks_;  // utime - log time of a channel's last message
  PartJoiner joiner_;
  ContentCheck content_;
};

}  // namespace

LogCheck check_log(const std::string& file, const KnownTypes& types) {
  LogReader reader(file, [&](std::string_view, const std::uint8_t* data, std::size_t size) {
    return check_message_of(types.of(data, size), data, size);
  });
  LogCheck check;
  Checker checker(check, types);
  std::size_t reported = 0;
  const auto tell_damages = [&] {
    for (; reported < reader.damages().size(); ++reported) {
      const LogDamage& damage = reader.damages()[reported];
      std::string text = fmt::format("{} bytes are damaged: {}", damage.end - damage.begin, damage.reason);
      if (damage.lost > 0) text += fmt::format(" ({} events lost)", damage.lost);
      check.findings.push_back({-1, damage.begin, "", text});
    }
  };
  while (const auto event = reader.next_view()) {
    const bool after_damage = reported < reader.damages().size();
    tell_damages();
    checker.add(*event, after_damage);
  }
  tell_damages();
  checker.finish();
  return check;
}

std::string format_finding(const LogFinding& finding) {
  std::string text = fmt::format("byte {}", finding.offset);
  if (finding.number >= 0) text += fmt::format(", event {}", finding.number);
  if (!finding.channel.empty()) text += ", " + printable(finding.channel);
  return text + ": " + finding.text;
}

}  // namespace lcmslam
