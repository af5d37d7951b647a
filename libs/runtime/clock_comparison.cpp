#include <lcmslam/runtime/clock_comparison.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace lcmslam {
namespace {

constexpr std::size_t most_hosts = 64, most_exchanges = 32;
constexpr Utime silence = 10'000'000;     // us
constexpr double longest_round = 1;       // s; a slower exchange tells nothing
constexpr double longest_offset = 3.2e9;  // s, a century

double difference(Utime a, Utime b) {
  return 1e-6 * (static_cast<double>(b) - static_cast<double>(a));
}

}  // namespace

command_t ClockComparison::tell(Utime now) const {
  command_t message;
  message.utime = now;
  message.seq = 0;
  message.sender = sender_;
  message.name = "clock";
  message.target = host_;
  for (const auto& [sender, host] : hosts_) {
    message.keys.push_back(std::to_string(sender));
    message.values.push_back(std::to_string(host.sent) + " " + std::to_string(host.heard));
  }
  message.n = static_cast<std::int32_t>(message.keys.size());
  return message;
}

void ClockComparison::hear(const command_t& message, Utime now) {
  if (message.name != "clock" || message.sender == sender_ || message.target == host_) return;
  for (auto host = hosts_.begin(); host != hosts_.end();)
    host =
        std::abs(difference(host->second.heard, now)) > 1e-6 * silence ? hosts_.erase(host) : std::next(host);
  if (hosts_.count(message.sender) == 0 && hosts_.size() >= most_hosts) return;
  Host& host = hosts_[message.sender];
  host.name = message.target.substr(0, 64);
  host.sent = message.utime;
  host.heard = now;
  const auto mine = std::find(message.keys.begin(), message.keys.end(), std::to_string(sender_));
  if (mine == message.keys.end()) return;
  std::istringstream words(message.values[static_cast<std::size_t>(mine - message.keys.begin())]);
  Utime sent = 0, heard = 0;
  if (!(words >> sent >> heard)) return;
  const double there = difference(sent, heard), back = difference(message.utime, now);
  const Exchange exchange{(there - back) / 2, there + back};
  // A reply to something of another time, or a clock that was set in between.
  if (!(exchange.round >= 0 && exchange.round < longest_round && std::abs(exchange.offset) < longest_offset))
    return;
  host.exchanges.push_back(exchange);
  if (host.exchanges.size() > most_exchanges) host.exchanges.pop_front();
}

std::map<std::string, ClockComparison::Offset> ClockComparison::offsets(Utime now) const {
  std::map<std::string, Offset> offsets;
  for (const auto& [sender, host] : hosts_) {
    if (host.exchanges.empty() || std::abs(difference(host.heard, now)) > 1e-6 * silence) continue;
    const auto fastest =
        std::min_element(host.exchanges.begin(), host.exchanges.end(),
                         [](const Exchange& a, const Exchange& b) { return a.round < b.round; });
    offsets[host.name] = {fastest->offset, fastest->round / 2};
  }
  return offsets;
}

}  // namespace lcmslam
