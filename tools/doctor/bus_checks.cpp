// The checks that use the bus.

#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <map>
#include <set>

#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include <lcmslam/runtime/udpm/multicast_address.hpp>
#include <lcmslam/runtime/udpm/source_filter.hpp>
#include <lcmslam/status_t.hpp>
#include "tools/doctor/checks.hpp"
#include "tools/launch/status_table.hpp"

namespace lcmslam {
namespace {

using Clock = std::chrono::steady_clock;
using Level = Finding::Level;

std::chrono::duration<double> seconds(double s) {
  return std::chrono::duration<double>(s);
}

std::int64_t microseconds_now() {
  return std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch()).count();
}

/// A STATUS this much older or newer than the clock is none of a process that runs now.
constexpr std::int64_t other_time = 60'000'000;  // us

bool is_of_now(const status_t& status) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();  // the clock of STATUS
  const std::int64_t utime = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  return status.utime > utime - other_time && status.utime < utime + other_time;
}

Finding no_lcm(const std::string& subject, const std::string& url) {
  return {Level::failure, subject, "LCM cannot use " + url, ""};
}

/// Everything heard on the bus within a time.
class Listener {
 public:
  void hear(const BusMessage& message) {
    if (message.channel.rfind("LCM_SELF_TEST", 0) == 0) return;
    channels.insert(message.channel);
    if (message.channel != "STATUS") return;
    try {
      const auto status = decode_message<status_t>(message.bytes.data(), message.bytes.size());
      const std::string process = fmt::format("{} ({})", status.process, status.pid);
      if (!is_of_now(status)) {
        recorded.insert(process);
      } else if (status.state == status_t::STOPPING) {
        running.erase(process);  // its last word: a graph that ends while we listen is in nobody's way
      } else {
        running[process] = status.process;
        refused[process] = status_value(status, "bus_foreign") + status_value(status, "bus_unsealed") +
                           status_value(status, "bus_malformed");
      }
    } catch (const DecodeError&) {
    }
  }
  std::set<std::string> channels, recorded;
  std::map<std::string, std::string> running;  // NAME (PID) -> NAME
  std::map<std::string, double> refused;       // packets, by the same
  Refusals refusals;                           // here
};

/// STATUS is at 1 Hz.
Listener listen(LcmBus& bus, double time) {
  Listener listener;
  const auto reader = bus.listen(ChannelSet::matching(".*"));
  const Clock::time_point end = Clock::now() + std::chrono::duration_cast<Clock::duration>(seconds(time));
  BusMessage message;
  while (Clock::now() < end)
    if (reader->read(message, std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now())))
      listener.hear(message);
  listener.refusals = reader->refusals();
  return listener;
}

std::string joined(const std::set<std::string>& texts, std::size_t most) {
  std::string all;
  std::size_t count = 0;
  for (const std::string& text : texts) {
    if (++count > most) return all + ", ...";
    all += (all.empty() ? "" : ", ") + text;
  }
  return all;
}

/// Who else sends here.
Finding judge_senders(const Listener& listener, const DoctorOptions& options) {
  Finding finding{Level::good, "other senders", "nobody else is heard on this bus", ""};
  if (listener.channels.empty()) return finding;
  finding.level = Level::note;
  finding.text = "others send here: " + joined(listener.channels, 8);
  if (listener.running.empty() && !listener.recorded.empty()) {
    finding.level = Level::warning;
    finding.text +=
        "; STATUS is of another time: a recording of a graph is played (or the clock of its machine is "
        "wrong): " +
        joined(listener.recorded, 8);
  }
  if (listener.running.empty()) return finding;
  const std::set<std::string> to_start(options.processes.begin(), options.processes.end());
  std::set<std::string> processes;
  finding.level = Level::warning;
  for (const auto& [process, name] : listener.running) {
    processes.insert(process);
    if (to_start.count(name) > 0) finding.level = Level::failure;  // a rival
  }
  finding.text =
      "a graph of lcmslam runs here already: " + joined(processes, 8) +
      "; a second one needs a port of its own (--lcm-url udpm://239.255.76.67:PORT?ttl=0) or, with "
      "launch, --private-bus";
  return finding;
}

/// What our own readers did not take.
Finding judge_refusals(const Listener& listener) {
  Finding finding{Level::good, "refused packets", "none came while listening", ""};
  finding.text = listener.refusals.text();
  if (!finding.text.empty()) finding.text = "while listening: " + finding.text;
  for (const auto& [process, count] : listener.refused)
    if (count > 0)
      finding.text += fmt::format("{}{} refused {:.0f} since its start", finding.text.empty() ? "" : "; ",
                                  process, count);
  if (finding.text.empty())
    finding.text = "none came while listening";
  else
    finding.level = Level::warning;
  return finding;
}

}  // namespace

Finding check_loop_back(const DoctorOptions& options) {
  Finding finding{Level::good, "loop-back test", "", ""};
  LcmBus sending(options.lcm_url), receiving(options.lcm_url);
  if (!sending.usable() || !receiving.usable()) return no_lcm(finding.subject, options.lcm_url);
  Inputs inputs;
  std::vector<double> latencies;  // s
  const std::string channel = fmt::format("LCMSLAM_DOCTOR_{}", getpid());
  const Input& input = inputs.subscribe<status_t>(channel, 1000, [&](const status_t& m) {
    latencies.push_back(1e-6 * static_cast<double>(microseconds_now() - m.utime));
  });
  const std::int64_t sender = draw_sender();
  LcmPublisher publisher(sending.lcm(), sender, largest_whole_message(options.lcm_url));
  Receiver receiver(receiving, inputs);
  const auto take_until = [&](Clock::time_point end) {
    Arrival arrival;
    while (Clock::now() < end && receiver.take(arrival, std::max(Clock::duration{0}, end - Clock::now())))
      arrival.deliver();
  };
  const auto period = std::chrono::duration_cast<Clock::duration>(seconds(1 / options.traffic.rate));
  const auto count = static_cast<std::size_t>(std::max(3.0, options.seconds * options.traffic.rate));
  status_t message{};
  message.detail.assign(options.traffic.largest, 'x');
  Clock::time_point next = Clock::now();
  for (std::size_t i = 0; i < count; ++i, next += period) {
    if (stop_requested()) return {Level::note, finding.subject, "was stopped", ""};
    message.utime = microseconds_now();
    publisher.publish(channel, message);
    take_until(next + period);
  }
  const Clock::time_point deadline = Clock::now() + std::chrono::seconds(1);
  while (latencies.size() < count && Clock::now() < deadline) take_until(Clock::now() + period);

  const std::size_t lost = count - std::min(count, latencies.size());
  std::sort(latencies.begin(), latencies.end());
  finding.text = fmt::format("{} of {} messages of {} kB at {:.3g} Hz came back", latencies.size(), count,
                             options.traffic.largest / 1000, options.traffic.rate);
  if (!latencies.empty())
    finding.text += fmt::format(", median {:.1f} ms, largest {:.1f} ms",
                                1e3 * latencies[latencies.size() / 2], 1e3 * latencies.back());
  if (publisher.split() > 0) finding.text += ", in pieces";
  const bool slow = !latencies.empty() && latencies[latencies.size() / 2] > 2 / options.traffic.rate;
  if (slow) {
    finding.level = Level::warning;
    finding.text += ": they pile up; send smaller or fewer ones";
  }
  if (lost == 0 && !slow) return finding;
  if (lost > 0) finding.level = lost == count ? Level::failure : Level::warning;
  const auto sender_count = input.senders.known().find(sender);
  if (sender_count != input.senders.known().end())
    finding.text += fmt::format(" ({} counted as lost)", sender_count->second.lost);
  const bool multicast = !multicast_address(options.lcm_url).group.empty();
  if (multicast) finding.cure = "sudo sysctl -w net.core.rmem_max=4194304";
  return finding;
}

std::vector<Finding> check_traffic(const DoctorOptions& options) {
  LcmBus bus(options.lcm_url);
  if (!bus.usable()) return {no_lcm("other senders", options.lcm_url)};
  const Listener listener = listen(bus, std::max(1.5, options.seconds));
  return {judge_senders(listener, options), judge_refusals(listener)};
}

Finding check_senders(const DoctorOptions& options) {
  return check_traffic(options).front();
}

Finding check_sources(const std::string& lcm_url) {
  Finding finding{Level::good, "sources", lcm_url + " has no strangers", ""};
  const MulticastAddress address = multicast_address(lcm_url);
  if (address.group.empty()) return finding;
  const bool listed = !udpm::allowed_networks().empty();
  finding.text = "packets of this machine alone are taken (ttl=0)";
  if (listed) finding.text = "packets of this machine and of LCMSLAM_BUS_ALLOW are taken";
  if (address.ttl == 0 || listed) return finding;
  finding.level = Level::warning;
  finding.text = fmt::format(
      "with ttl={} whoever can send to {} can steer the graph; name the machines that may in "
      "LCMSLAM_BUS_ALLOW, e.g. \"10.0.0.5, 10.0.1.0/24\"",
      address.ttl, address.group);
  return finding;
}

}  // namespace lcmslam
