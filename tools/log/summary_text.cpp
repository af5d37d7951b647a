#include <fmt/chrono.h>
#include <fmt/format.h>

#include <lcmslam/messages/print_message.hpp>
#include <lcmslam/messages/schema.hpp>
#include "tools/log/log_summary.hpp"

namespace lcmslam {
namespace {

double seconds(Utime utime) {
  return 1e-6 * static_cast<double>(utime);
}

/// Wall clock where the time can be one (after 2001), plain microseconds otherwise.
std::string time_text(Utime utime) {
  if (utime < 1'000'000'000'000'000 || utime > 9'000'000'000'000'000) return fmt::format("{} us", utime);
  return fmt::format("{} us ({:%Y-%m-%d %H:%M:%S} UTC)", utime,
                     fmt::gmtime(static_cast<std::time_t>(utime / 1'000'000)));
}

std::string types_text(const ChannelSummary& channel) {
  std::string text;
  const auto add = [&](const std::string& name, std::int64_t n) {
    if (n == 0) return;
    if (!text.empty()) text += ", ";
    text += n == channel.count ? name : fmt::format("{} ({})", name, n);
  };
  for (const auto& [type, n] : channel.types) add(type_name(type), n);
  add("other types", channel.other_types);
  add("no type", channel.untyped);
  return text;
}

std::string lost_text(const ChannelSummary& channel) {
  return channel.senders.known().empty() ? "-" : std::to_string(channel.senders.total().lost);
}

std::string sessions_text(const LogSummary& summary) {
  if (summary.sessions.size() == 1) {
    const SessionSummary& s = summary.sessions.front();
    return fmt::format("  {:.3f} s, from {} to {}\n", seconds(time_between(s.first, s.last)),
                       time_text(s.first), time_text(s.last));
  }
  std::string text =
      fmt::format("  {} sessions (time or event numbers begin anew)\n", summary.sessions.size());
  for (const SessionSummary& s : summary.sessions)
    text += fmt::format("    at byte {}: {} events, {:.3f} s, from {}\n", s.offset, s.events,
                        seconds(time_between(s.first, s.last)), time_text(s.first));
  return text;
}

}  // namespace

std::string type_name(std::uint64_t fingerprint) {
  const MessageType* type = MessageType::find(fingerprint);
  return type != nullptr ? type->name : fmt::format("{:016x}", fingerprint);
}

std::string format_summary(const LogSummary& summary) {
  std::string text =
      fmt::format("{}: {:.2f} MB, {} events, {} channels\n", summary.file,
                  static_cast<double>(summary.size) / 1e6, summary.events, summary.channels.size());
  if (summary.events > 0) text += sessions_text(summary);
  if (summary.jumps_back > 0)
    text += fmt::format("  {} events have an earlier time than the one before (at most {:.6f} s)\n",
                        summary.jumps_back, seconds(summary.largest_jump_back));
  std::size_t width = 7;
  for (const auto& [name, channel] : summary.channels) width = std::max(width, printable(name).size());
  text += fmt::format("  {:<{}} {:>8} {:>8} {:>10} {:>10} {:>9} {:>5} {:>6}  {}\n", "channel", width,
                      "messages", "Hz", "mean B", "largest B", "gap s", "back", "lost", "type");
  for (const auto& [name, c] : summary.channels)
    text += fmt::format("  {:<{}} {:>8} {:>8.2f} {:>10} {:>10} {:>9.3f} {:>5} {:>6}  {}\n", printable(name),
                        width, c.count, c.rate, c.bytes / c.count, c.largest, seconds(c.largest_gap),
                        c.jumps_back, lost_text(c), types_text(c));
  for (const auto& [name, c] : summary.in_pieces)
    text += fmt::format("  {}: {} whole messages in {} pieces, {} incomplete\n", printable(name), c.whole,
                        c.pieces, c.incomplete);
  if (!summary.damages.empty())
    text += fmt::format("  damaged at {} places; `lcmslam log check` lists them\n", summary.damages.size());
  return text;
}

}  // namespace lcmslam
