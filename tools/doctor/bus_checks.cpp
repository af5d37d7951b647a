// The checks that use the bus.

#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <map>
#include <set>

#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/status_t.hpp>
#include "tools/doctor/checks.hpp"

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
  void hear(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
    if (channel.rfind("LCM_SELF_TEST", 0) == 0) return;
    channels.insert(channel);
    if (channel != "STATUS") return;
    try {
      const auto status =
          decode_message<status_t>(static_cast<const std::uint8_t*>(buffer->data), buffer->data_size);
      const std::string process = fmt::format("{} ({})", status.process, status.pid);
      if (!is_of_now(status)) {
        recorded.insert(process);
      } else if (status.state == status_t::STOPPING) {
        running.erase(process);  // its last word: a graph that ends while we listen is in nobody's way
      } else {
        running[process] = status.process;
      }
    } catch (const DecodeError&) {
    }
  }
  std::set<std::string> channels, recorded;
  std::map<std::string, std::string> running;  // NAME (PID) -> NAME
};

std::string joined(const std::set<std::string>& texts, std::size_t most) {
  std::string all;
  std::size_t count = 0;
  for (const std::string& text : texts) {
    if (++count > most) return all + ", ...";
    all += (all.empty() ? "" : ", ") + text;
  }
  return all;
}

}  // namespace

Finding check_loop_back(const DoctorOptions& options) {
  Finding finding{Level::good, "loop-back test", "", ""};
  lcm::LCM sending(options.lcm_url), receiving(options.lcm_url);
  if (!is_usable(sending) || !is_usable(receiving)) return no_lcm(finding.subject, options.lcm_url);
  Inputs inputs;
  std::vector<double> latencies;  // s
  const std::string channel = fmt::format("LCMSLAM_DOCTOR_{}", getpid());
  const Input& input = inputs.subscribe<status_t>(channel, 1000, [&](const status_t& m) {
    latencies.push_back(1e-6 * static_cast<double>(microseconds_now() - m.utime));
  });
  const std::int64_t sender = draw_sender();
  LcmPublisher publisher(sending, sender, largest_whole_message(options.lcm_url));
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
  const auto sender_count = input.senders.find(sender);
  if (sender_count != input.senders.end())
    finding.text += fmt::format(" ({} counted as lost)", sender_count->second.lost);
  const bool multicast = !multicast_address(options.lcm_url).group.empty();
  if (multicast) finding.cure = "sudo sysctl -w net.core.rmem_max=4194304";
  return finding;
}

Finding check_senders(const DoctorOptions& options) {
  Finding finding{Level::good, "other senders", "nobody else is heard on this bus", ""};
  lcm::LCM lcm(options.lcm_url);
  if (!is_usable(lcm)) return no_lcm(finding.subject, options.lcm_url);
  Listener listener;
  lcm.subscribe(".*", &Listener::hear, &listener);
  const Clock::time_point end = Clock::now() + std::chrono::duration_cast<Clock::duration>(seconds(
                                                   std::max(1.5, options.seconds)));  // STATUS is at 1 Hz
  while (Clock::now() < end)
    lcm.handleTimeout(static_cast<int>(std::max<std::int64_t>(
        1, std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count())));
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

}  // namespace lcmslam
