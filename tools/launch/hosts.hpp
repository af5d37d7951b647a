#pragma once
// A graph on several hosts, as one launch sees it: what runs elsewhere, and how the clocks agree.

#include <chrono>
#include <map>

#include <lcmslam/runtime/clock_comparison.hpp>
#include <lcmslam/status_t.hpp>
#include "tools/launch/graph.hpp"

namespace lcmslam {

/// udpm URL with this ttl; 0 and other providers: as it is.
std::string with_ttl(const std::string& lcm_url, int ttl);

/// What keeps a graph from spanning hosts; empty: nothing.
std::string obstacle_between_hosts(const Graph& graph);

class Elsewhere {
 public:
  Elsewhere(const Graph& graph, std::int64_t sender)
      : clocks_(graph.host, sender), hosts_(graph.elsewhere), largest_offset_(graph.launch.clock_offset) {}

  bool any() const { return !hosts_.empty(); }
  /// Whether the message is of a process of another host.
  bool take(const status_t& status);
  void hear(const command_t& message, Utime now) { clocks_.hear(message, now); }
  command_t tell(Utime now) const { return clocks_.tell(now); }

  /// A line for each process and each clock that is not in time.
  std::string format(Utime now) const;
  /// What is to be said now: a clock that has gone wrong, once.
  std::string warning(Utime now);

 private:
  using Clock = std::chrono::steady_clock;
  struct Heard {
    status_t status;
    Clock::time_point at;
  };
  ClockComparison clocks_;
  std::map<std::string, std::string> hosts_;  // by process
  std::map<std::string, Heard> heard_;        // by process
  std::map<std::string, bool> wrong_;         // clocks, by host
  double largest_offset_;                     // s
};

}  // namespace lcmslam
