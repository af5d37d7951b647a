#include "launch/status_table.hpp"

#include <fmt/format.h>

namespace lcmslam {
namespace {

const char* state_name(int state) {
  static const char* const names[] = {"starting", "running", "finished", "stopping", "FAILED"};
  return state >= 0 && state < 5 ? names[state] : "?";
}

std::string rates(const status_t& status) {
  std::map<std::string, double> inputs;  // over all senders
  for (const auto& in : status.inputs)
    if (in.channel != "STATUS" && in.rate > 0) inputs[in.channel] += in.rate;
  std::string text;
  for (const auto& [channel, rate] : inputs) text += fmt::format("{} {:.0f} ", channel, rate);
  text += "->";
  for (const auto& out : status.outputs)
    if (out.channel != "STATUS" && out.rate > 0) text += fmt::format(" {} {:.0f}", out.channel, out.rate);
  return text;
}

}  // namespace

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
  std::string table =
      fmt::format("{:<11} {:>7} {:<9} {:>5} {:>7} {:>11} {:>5} {:>6} {:>5} {:>4}  {}\n", "process", "pid",
                  "state", "CPU%", "MB", "p50/p95 ms", "lost", "kernel", "drops", "bad", "channels (Hz)");
  for (const auto& process : processes) {
    const std::string& name = process.spec.name;
    const auto found = board.find(name);
    if (process.pid == 0 || found == board.end()) {
      const std::string state = process.pid != 0 ? "starting" : process.last_exit;
      table += fmt::format("{:<11} {:>7} {}\n", name, process.pid, state);
      continue;
    }
    const status_t& s = found->second;
    ChannelLoss all;
    for (const auto& in : s.inputs) {
      all.lost += in.lost;
      all.queue_drops += in.queue_drops;
      all.decode_errors += in.decode_errors;
    }
    table +=
        fmt::format("{:<11} {:>7} {:<9} {:>5.0f} {:>7.0f} {:>5.0f}/{:<5.0f} {:>5} {:>6} {:>5} {:>4}  {}\n",
                    name, process.pid, state_name(s.state), 100 * s.cpu, static_cast<double>(s.memory) / 1e6,
                    1e3 * s.latency_p50, 1e3 * s.latency_p95, all.lost, s.kernel_drops, all.queue_drops,
                    all.decode_errors, rates(s));
  }
  return table;
}

}  // namespace lcmslam
