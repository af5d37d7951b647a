#include <lcmslam/runtime/status_reporter.hpp>

#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <utility>

#include <lcmslam/runtime/machine.hpp>

namespace lcmslam {
namespace {

constexpr double shortest_share = 0.02;  // s: the kernel counts processor time in steps of some ms
constexpr std::size_t most_waiting = 200;
constexpr std::size_t most_latencies = 300;

Utime wall_clock() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// Quantile (0..1) by nearest rank, 0 for no values.
double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(values.size())));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(rank, 1) - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// In words. Of numbered messages a missing one shows as a gap too; of others only here.
std::string trouble_of(const Input& input, const Receiver::QueueCount& queue) {
  if (queue.incomplete == 0) return input.last_error;
  return fmt::format("{}{} messages lacked pieces", input.last_error.empty() ? "" : input.last_error + "; ",
                     queue.incomplete);
}

void say_too(NodeReport& report, const std::string& trouble) {
  if (!trouble.empty()) report.detail += (report.detail.empty() ? "" : "; ") + trouble;
}

}  // namespace

bool just_started(const status_t& status) {
  return status.uptime < 0.5;
}

NodeReport with_stopped(NodeReport report, const std::vector<std::string>& channels) {
  for (const std::string& channel : channels) say_too(report, channel + " comes no more");
  return report;
}

NodeReport with_stamps(NodeReport report, const StampJudge& stamps) {
  say_too(report, stamps.trouble());
  if (stamps.refused() > 0)
    report.values.emplace_back("stamps_refused", static_cast<double>(stamps.refused()));
  if (stamps.foreign() > 0)
    report.values.emplace_back("of_other_senders", static_cast<double>(stamps.foreign()));
  return report;
}

StatusReporter::StatusReporter(std::string process, Publisher& publisher)
    : process_(std::move(process)), publisher_(publisher), last_cpu_(process_cpu_seconds()) {
  publisher_.on_answer = [this](Utime utime) { answered(utime); };
}

void StatusReporter::arrived(Utime utime, SteadyTime time) {
  waiting_[utime] = time;
  if (waiting_.size() <= most_waiting) return;
  waiting_.erase(std::min_element(waiting_.begin(), waiting_.end(),
                                  [](const auto& a, const auto& b) { return a.second < b.second; }));
}

void StatusReporter::answered(Utime utime) {
  const auto found = waiting_.find(utime);
  if (found == waiting_.end()) return;
  const std::chrono::duration<double> latency = std::chrono::steady_clock::now() - found->second;
  waiting_.erase(found);
  if (latencies_.size() == most_latencies) latencies_.erase(latencies_.begin());
  latencies_.push_back(latency.count());
}

double StatusReporter::rate(const std::string& key, std::int64_t now_value, double seconds) {
  const auto found = last_values_.find(key);
  const std::int64_t before = found == last_values_.end() ? 0 : found->second;
  values_[key] = now_value;
  // A sender that was forgotten meanwhile and has come again begins with nothing.
  return seconds > 0 ? static_cast<double>(std::max<std::int64_t>(0, now_value - before)) / seconds : 0;
}

status_t StatusReporter::gather(const NodeReport& of_node, const Inputs& inputs, Receiver& receiver) {
  const NodeReport node = with_stamps(of_node, inputs.stamps());
  const SteadyTime now = std::chrono::steady_clock::now();
  const double seconds = std::chrono::duration<double>(now - last_).count();
  const SocketState socket = receiver.socket();

  status_t s;
  s.utime = wall_clock();
  s.process = process_;
  s.pid = getpid();
  s.state = static_cast<int8_t>(node.state);
  s.detail = node.detail;
  s.uptime = std::chrono::duration<double>(now - start_).count();
  s.cpu_total = process_cpu_seconds();
  s.cpu = seconds > shortest_share ? (s.cpu_total - last_cpu_) / seconds : 0;
  s.memory = resident_bytes();
  s.kernel_drops = socket.kernel_drops;
  s.receive_buffer = socket.receive_buffer;
  s.latency_p50 = quantile(latencies_, 0.5);
  s.latency_p95 = quantile(latencies_, 0.95);

  const auto queues = receiver.counts();
  for (const auto& input : inputs.all()) {
    auto senders = input->senders.table();
    if (senders.empty()) senders[0] = {};
    const InputCount& forgotten = input->senders.forgotten();  // came long ago: no part of a rate
    bool first = true;  // what belongs to the channel stands with its first sender
    for (const auto& [sender, count] : senders) {
      const std::string key = input->channel() + std::to_string(sender);
      input_status_t in;
      in.channel = input->channel();
      in.sender = sender;
      in.received = count.received;
      in.decode_errors = first ? input->decode_errors + queues.at(input.get()).bad_parts : 0;
      in.lost = count.lost;
      in.duplicates = count.duplicates;
      in.reordered = count.reordered;
      in.queue_drops = first ? queues.at(input.get()).drops : 0;
      in.last_seq = count.last_seq;
      in.last_utime = count.last_utime;
      in.rate = rate(key + "#", count.received - (sender == 0 ? forgotten.received : 0), seconds);
      in.bytes_per_second = rate(key + "b", count.bytes - (sender == 0 ? forgotten.bytes : 0), seconds);
      in.queue_age = first ? queues.at(input.get()).oldest : 0;
      in.last_error = first ? trouble_of(*input, queues.at(input.get())) : "";
      s.inputs.push_back(in);
      first = false;
    }
  }
  for (const auto& [channel, count] : publisher_.counts()) {
    output_status_t out;
    out.channel = channel;
    out.sent = count.sent;
    out.last_seq = count.sent - 1;
    out.last_utime = count.last_utime;
    out.rate = rate("out#" + channel, count.sent, seconds);
    out.bytes_per_second = rate("outb" + channel, count.bytes, seconds);
    out.largest = count.largest;
    s.outputs.push_back(out);
  }
  const auto add_value = [&](const std::string& name, double value) {
    value_t v;
    v.name = name;
    v.value = value;
    s.values.push_back(v);
  };
  for (const auto& [name, value] : node.values) add_value(name, value);
  const Refusals refusals = receiver.refusals();
  add_value("bus_foreign", static_cast<double>(refusals.foreign()));
  add_value("bus_unsealed", static_cast<double>(refusals.unsealed()));
  if (const std::int64_t count = refusals.of(Refusal::other_time); count > 0) {
    add_value("bus_other_time", static_cast<double>(count));
    add_value("bus_other_time_age", refusals.last_age);
  }
  add_value("bus_malformed", static_cast<double>(refusals.malformed()));
  add_value("bus_incomplete", static_cast<double>(refusals.incomplete()));
  s.n_inputs = static_cast<int32_t>(s.inputs.size());
  s.n_outputs = static_cast<int32_t>(s.outputs.size());
  s.n_values = static_cast<int32_t>(s.values.size());
  last_values_ = std::exchange(values_, {});  // those of senders that were forgotten are gone
  last_ = now;
  last_cpu_ = s.cpu_total;
  return s;
}

}  // namespace lcmslam
