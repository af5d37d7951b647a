#include "tools/spy/spy_report.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sstream>

#include <lcmslam/evaluation/table.hpp>
#include <lcmslam/messages/print_message.hpp>

namespace lcmslam {
namespace {

std::string notes(const ChannelReport& c) {
  std::vector<std::string> notes;
  if (c.pieces > 0) notes.emplace_back("in parts");
  if (c.pieces > 0 && c.count == 0) notes.push_back(fmt::format("{} pieces, no whole message", c.pieces));
  if (c.lost_pieces > 0) notes.push_back(fmt::format("{} pieces lost", c.lost_pieces));
  if (c.types > 1) notes.push_back(fmt::format("{} types", c.types));
  if (c.senders > 1) notes.push_back(fmt::format("{} senders", c.senders));
  if (c.duplicates > 0) notes.push_back(fmt::format("{} twice", c.duplicates));
  if (c.reordered > 0) notes.push_back(fmt::format("{} out of order", c.reordered));
  if (!c.last_error.empty()) notes.push_back(printable(c.last_error));
  return fmt::format("{}", fmt::join(notes, ", "));
}

/// Senders that number their messages show their gaps; of the others nobody knows.
std::string gaps(const ChannelReport& c) {
  return c.senders > 0 ? std::to_string(c.lost) : "-";
}

std::string rate(double value, int decimals) {
  return value > 0 ? fixed_number(value, decimals) : "-";
}

std::string footer(const SpyReport& report) {
  std::string text = fmt::format(
      "listened to {} for {:.0f} s\nspy's own socket: receive buffer {:.0f} kB, {} dropped by the kernel\n",
      report.lcm_url, report.seconds, static_cast<double>(report.socket.receive_buffer) / 1e3,
      report.socket.kernel_drops);
  if (report.socket.kernel_drops > 0)
    text += "  these datagrams were on the bus: gaps above may be spy's own (./lcmslam doctor says why)\n";
  if (report.dropped > 0)
    text += fmt::format("  {} messages came too fast for spy: gaps above may be its own\n", report.dropped);
  if (report.refusals.any()) text += fmt::format("refused: {}\n", report.refusals.text());
  if (report.left_out > 0)
    text += fmt::format("  {} messages on further channels are not shown\n", report.left_out);
  if (report.channels.empty())
    text += "  nothing was heard: is something running, with the same --lcm-url or LCM_DEFAULT_URL?\n";
  return text;
}

}  // namespace

std::string spy_text(const SpyReport& report) {
  Table table({"channel", "type", "count", "Hz", "jitter ms", "kB/s", "max kB", "gaps", "age s", "bad"});
  for (const ChannelReport& c : report.channels)
    table.add({printable(c.channel), c.type, std::to_string(c.count), rate(c.rate.hz, 1),
               c.rate.hz > 0 ? fixed_number(1e3 * c.rate.jitter, 1) : "-",
               rate(c.rate.bytes_per_second / 1e3, 1), fixed_number(static_cast<double>(c.largest) / 1e3, 1),
               gaps(c), fixed_number(c.age, 1), std::to_string(c.decode_errors)});
  // Notes are long and differ: they follow their line and widen no column.
  std::istringstream lines(table.text());
  std::string text, line;
  for (std::size_t i = 0; std::getline(lines, line); ++i) {
    line.erase(line.find_last_not_of(' ') + 1);
    const std::string note = i > 1 ? notes(report.channels[i - 2]) : "";
    text += line + (note.empty() ? "" : "  " + note) + "\n";
  }
  return text + footer(report);
}

std::string spy_json(const SpyReport& report) {
  using Json = nlohmann::ordered_json;
  Json channels = Json::array();
  for (const ChannelReport& c : report.channels)
    channels.push_back({{"channel", printable(c.channel)},
                        {"type", c.type},
                        {"types", c.types},
                        {"count", c.count},
                        {"hz", c.rate.hz},
                        {"jitter_ms", 1e3 * c.rate.jitter},
                        {"bytes_per_second", c.rate.bytes_per_second},
                        {"largest", c.largest},
                        {"senders", c.senders},
                        {"gaps", c.lost},
                        {"duplicates", c.duplicates},
                        {"reordered", c.reordered},
                        {"age", c.age},
                        {"decode_errors", c.decode_errors},
                        {"last_error", printable(c.last_error)},
                        {"in_parts", c.pieces > 0},
                        {"pieces", c.pieces},
                        {"lost_pieces", c.lost_pieces},
                        {"incomplete", c.incomplete}});
  const Json json = {{"lcm_url", report.lcm_url},
                     {"seconds", report.seconds},
                     {"channels", channels},
                     {"left_out", report.left_out},
                     {"receive_buffer", report.socket.receive_buffer},
                     {"kernel_drops", report.socket.kernel_drops},
                     {"dropped", report.dropped},
                     {"refused_foreign", report.refusals.foreign()},
                     {"refused_unsealed", report.refusals.unsealed()},
                     {"refused_other_time", report.refusals.of(Refusal::other_time)},
                     {"refused_malformed", report.refusals.malformed()},
                     {"incomplete", report.refusals.incomplete()}};
  return json.dump() + "\n";
}

std::string fit_to_screen(const std::string& text, std::size_t rows, std::size_t columns) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    std::size_t end = 0;  // bytes of the first `columns` code points
    for (std::size_t n = 0; end < line.size() && n < columns; ++n)
      for (++end; end < line.size() && (static_cast<unsigned char>(line[end]) & 0xc0) == 0x80;) ++end;
    lines.push_back(line.substr(0, end));
  }
  if (rows > 1 && lines.size() >= rows) {
    const std::size_t hidden = lines.size() - (rows - 2);
    lines.resize(rows - 2);
    lines.push_back(fmt::format("... {} more lines", hidden));
  }
  return fmt::format("{}\n", fmt::join(lines, "\n"));
}

}  // namespace lcmslam
