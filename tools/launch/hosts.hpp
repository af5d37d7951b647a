#pragma once
// A graph on several hosts, as one launch sees it: what runs elsewhere, and how the clocks agree.

#include <chrono>
#include <map>
#include <string>
#include <vector>

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
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds word_period{250};    ///< between two words of a launch
  static constexpr std::chrono::milliseconds longest_pause{800};  ///< then its host is lost

  Elsewhere(const Graph& graph, std::int64_t sender)
      : clocks_(graph.host, sender), hosts_(graph.elsewhere), largest_offset_(graph.launch.clock_offset) {}

  bool any() const { return !hosts_.empty(); }
  /// Whether the message is of a process of another host.
  bool take(const status_t& status);
  void hear(const command_t& message, Utime now, Clock::time_point at = Clock::now());
  command_t tell(Utime now) const { return clocks_.tell(now); }

  /// A line for each process and each clock that is not in time.
  std::string format(Utime now) const;
  /// What is to be said now: a clock that has gone wrong, once.
  std::string warning(Utime now);
  /// Hosts that are lost, or are heard again, since it was last asked.
  std::vector<std::string> news(Clock::time_point now = Clock::now());

 private:
  struct Launch {
    Clock::time_point heard;
    bool lost = false;
  };
  struct Heard {
    status_t status;
    Clock::time_point at;
  };
  ClockComparison clocks_;
  std::map<std::string, std::string> hosts_;  // by process
  std::map<std::string, Heard> heard_;        // by process
  std::map<std::string, Launch> launches_;    // by host
  std::map<std::string, bool> wrong_;         // clocks, by host
  double largest_offset_;                     // s
};

}  // namespace lcmslam
