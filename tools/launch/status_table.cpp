#include "tools/launch/status_table.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <sstream>
#include <vector>

#include <lcmslam/messages/print_message.hpp>
#include <lcmslam/runtime/refusals.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t width = 80;

/// Words at most `width` long a line, indented. They are of whoever sent the STATUS.
std::string wrapped(const std::string& text) {
  std::string lines, line = " ";
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    word = printable(word);
    if (line.size() + 1 + word.size() > width && line.find_first_not_of(' ') != std::string::npos) {
      lines += line + "\n";
      line = "   ";
    }
    line += " " + word;
  }
  return line.find_first_not_of(' ') != std::string::npos ? lines + line + "\n" : lines;
}

std::string rates(const status_t& status) {
  std::map<std::string, double> inputs;  // over all senders
  for (const auto& in : status.inputs)
    if (in.channel != "STATUS" && in.rate > 0) inputs[in.channel] += in.rate;
  std::string text;
  for (const auto& [channel, rate] : inputs) text += fmt::format("{} {:.0f} ", channel, rate);
  std::string out_text;
  for (const auto& out : status.outputs)
    if (out.channel != "STATUS" && out.rate > 0) out_text += fmt::format(" {} {:.0f}", out.channel, out.rate);
  return text.empty() && out_text.empty() ? "" : "Hz: " + text + "->" + out_text;
}

bool waits(const status_t& status) {
  return status.state == status_t::RUNNING && status.detail.find("waits for") != std::string::npos;
}

/// How good it is, as far as it counts that itself.
std::string quality(const status_t& status) {
  static const std::pair<const char*, const char*> counts[] = {{"keypoints", "features a frame"},
                                                               {"landmarks", "landmarks"},
                                                               {"matched", "of them seen"},
                                                               {"keyframes", "keyframes"},
                                                               {"map_points", "points"}};
  std::vector<std::string> parts;
  if (const double steps = status_value(status, "steps"); steps > 0)
    parts.push_back(fmt::format("{:.0f} % of {:.0f} frames placed in the map",
                                100 * (1 - status_value(status, "lost") / steps), steps));
  for (const auto& [name, words] : counts)
    if (const double value = status_value(status, name); value > 0)
      parts.push_back(fmt::format("{:.0f} {}", value, words));
  return fmt::format("{}", fmt::join(parts, ", "));
}

// One line for each channel and sender that did not come through clean.
std::string trouble(const std::string& process, const status_t& status) {
  std::string text;
  const double foreign = status_value(status, "bus_foreign");
  const double unsealed = status_value(status, "bus_unsealed");
  const double malformed = status_value(status, "bus_malformed");
  const double incomplete = status_value(status, "bus_incomplete");
  const double at_other_times = status_value(status, "bus_other_time");
  if (unsealed > at_other_times)
    text += fmt::format("  {} <- bus: {:.0f} messages that are not sealed by its key\n", process,
                        unsealed - at_other_times);
  if (at_other_times > 0)
    text += fmt::format("  {} <- bus: {:.0f} {}\n", process, at_other_times,
                        describe_other_time(status_value(status, "bus_other_time_age")));
  if (foreign + malformed + incomplete > 0)
    text += fmt::format(
        "  {} <- bus: {:.0f} packets of strangers, {:.0f} malformed, {:.0f} messages lacked "
        "fragments\n",
        process, foreign, malformed, incomplete);
  for (const auto& in : status.inputs) {
    if (in.lost + in.duplicates + in.reordered + in.decode_errors + in.queue_drops == 0 &&
        in.last_error.empty())
      continue;
    text += fmt::format(
        "  {} <- {} of {:08x}: {} received, {} lost, {} twice, {} out of order, {} malformed, {} skipped, "
        "{:.0f} ms in the queue{}\n",
        process, printable(in.channel), static_cast<std::uint32_t>(in.sender), in.received, in.lost,
        in.duplicates, in.reordered, in.decode_errors, in.queue_drops, 1e3 * in.queue_age,
        in.last_error.empty() ? "" : " (" + printable(in.last_error) + ")");
  }
  return text;
}

}  // namespace

const char* state_name(int state) {
  static const char* const names[] = {"starting", "running", "finished", "stopping", "FAILED"};
  return state >= 0 && state < 5 ? names[state] : "?";
}

void take_status(StatusBoard& board, const status_t& status,
                 const std::vector<Supervisor::State>& processes) {
  for (const auto& process : processes)
    if (process.spec.name == status.process && process.pid == status.pid) board[status.process] = status;
}

ChannelLoss channel_loss(const status_t& status, const std::string& channel) {
  ChannelLoss sum;
  for (const auto& in : status.inputs) {
    if (in.channel != channel) continue;
    sum.received += in.received;
    sum.lost += in.lost;
    sum.duplicates += in.duplicates;
    sum.reordered += in.reordered;
    sum.decode_errors += in.decode_errors;
    sum.queue_drops += in.queue_drops;
  }
  return sum;
}

double status_value(const status_t& status, const std::string& name) {
  for (const auto& value : status.values)
    if (value.name == name) return value.value;
  return 0;
}

std::string format_status(const StatusBoard& board, const std::vector<Supervisor::State>& processes) {
  const auto* const columns = "{:<11}{:>7} {:<8}{:>5}{:>6}{:>11}{:>6}{:>7}{:>6}{:>5}{:>7}\n";
  std::string table = fmt::format(columns, "process", "pid", "state", "CPU%", "MB", "p50/p95 ms", "lost",
                                  "kernel", "drops", "bad", "age ms");
  std::string troubles;
  for (const auto& process : processes) {
    const std::string& name = process.spec.name;
    const auto found = board.find(name);
    if (process.pid == 0 || found == board.end()) {
      const std::string state = process.pid != 0 ? "starting"
                                : process.waits  ? "waits for others to be ready"
                                                 : process.last_exit;
      table += fmt::format("{:<11}{:>7} {}\n", name, process.pid, state);
      continue;
    }
    const status_t& s = found->second;
    ChannelLoss all;
    double queue_age = 0;
    for (const auto& in : s.inputs) {
      queue_age = std::max(queue_age, in.queue_age);
      all.lost += in.lost;
      all.queue_drops += in.queue_drops;
      all.decode_errors += in.decode_errors;
    }
    const auto whole = [](double value) { return fmt::format("{:.0f}", value); };
    table += fmt::format(columns, name, process.pid, waits(s) ? "waits" : state_name(s.state),
                         whole(100 * s.cpu), whole(static_cast<double>(s.memory) / 1e6),
                         whole(1e3 * s.latency_p50) + "/" + whole(1e3 * s.latency_p95), all.lost,
                         s.kernel_drops, all.queue_drops, all.decode_errors, whole(1e3 * queue_age));
    table += wrapped(s.detail) + wrapped(rates(s)) + wrapped(quality(s));
    troubles += trouble(name, s);
  }
  return table + troubles;
}

}  // namespace lcmslam
