#include "tools/launch/hosts.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include <lcmslam/runtime/udpm/multicast_address.hpp>
#include "tools/launch/status_table.hpp"

namespace lcmslam {

std::string with_ttl(const std::string& lcm_url, int ttl) {
  if (ttl == 0 || multicast_address(lcm_url).group.empty()) return lcm_url;
  const std::string value = "ttl=" + std::to_string(ttl);
  const std::size_t question = lcm_url.find('?');
  if (question == std::string::npos) return lcm_url + "?" + value;
  for (const char* begin : {"?ttl=", "&ttl="}) {
    const std::size_t at = lcm_url.find(begin, question);
    if (at == std::string::npos) continue;
    const std::size_t end = std::min(lcm_url.find('&', at + 1), lcm_url.size());
    return lcm_url.substr(0, at + 1) + value + lcm_url.substr(end);
  }
  return lcm_url + "&" + value;
}

std::string obstacle_between_hosts(const Graph& graph) {
  const MulticastAddress address = multicast_address(graph.lcm_url);
  if (graph.elsewhere.empty() || address.group.empty() || address.ttl > 0) return {};
  const auto& [process, host] = *graph.elsewhere.begin();
  return fmt::format(
      "{} runs on {}, but with ttl=0 no packet leaves this machine: set launch.ttl to 1, on each host",
      process, host);
}

bool Elsewhere::take(const status_t& status) {
  if (hosts_.count(status.process) == 0) return false;
  heard_[status.process] = {status, Clock::now()};
  return true;
}

void Elsewhere::hear(const command_t& message, Utime now, Clock::time_point at) {
  clocks_.hear(message, now);
  const auto is_there = [&](const auto& process) { return process.second == message.target; };
  if (message.name == "clock" && std::any_of(hosts_.begin(), hosts_.end(), is_there))
    launches_.try_emplace(message.target, Launch{at}).first->second.heard = at;
}

std::vector<std::string> Elsewhere::news(Clock::time_point now) {
  std::vector<std::string> news;
  for (auto& [host, launch] : launches_) {
    if ((now - launch.heard > longest_pause) == launch.lost) continue;
    launch.lost = !launch.lost;
    std::string processes;
    for (const auto& [process, where] : hosts_)
      if (where == host) processes += (processes.empty() ? "" : ", ") + process;
    news.push_back(launch.lost
                       ? fmt::format("{} is lost: no word from its launch for {:.1f} s; there run {}", host,
                                     std::chrono::duration<double>(now - launch.heard).count(), processes)
                       : fmt::format("{} is heard again: {}", host, processes));
  }
  return news;
}

std::string Elsewhere::format(Utime now) const {
  std::string text;
  for (const auto& [process, host] : hosts_) {
    const auto found = heard_.find(process);
    if (found == heard_.end()) {
      text += fmt::format("  {} on {}: not heard yet\n", process, host);
      continue;
    }
    const double silent = std::chrono::duration<double>(Clock::now() - found->second.at).count();
    const std::string age = silent > 3 ? fmt::format(", silent for {:.0f} s", silent) : "";
    text += fmt::format("  {} on {}: {}{}\n", process, host, state_name(found->second.status.state), age);
  }
  for (const auto& [host, clock] : clocks_.offsets(now))
    text +=
        fmt::format("  {}'s clock: {:+.2f} ms (+- {:.2f})\n", host, 1e3 * clock.offset, 1e3 * clock.error);
  return text;
}

std::string Elsewhere::warning(Utime now) {
  std::string text;
  for (const auto& [host, clock] : clocks_.offsets(now)) {
    const bool wrong = std::abs(clock.offset) - clock.error > largest_offset_;
    if (wrong && !wrong_[host])
      text += fmt::format(
          "{}'s clock is {:.1f} ms {} this one's: stamps of the two hosts do not fit together. Let both "
          "follow the same "
          "time server (chrony, or systemd-timesyncd)",
          host, 1e3 * std::abs(clock.offset), clock.offset > 0 ? "ahead of" : "behind");
    wrong_[host] = wrong;
  }
  return text;
}

}  // namespace lcmslam
