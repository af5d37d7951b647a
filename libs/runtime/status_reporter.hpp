#pragma once
// Gathers STATUS.

#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/runtime/node.hpp>
#include <lcmslam/status_t.hpp>

namespace lcmslam {

/// The node's own report, and what its inputs' stamps gave to say.
NodeReport with_stamps(NodeReport report, const StampJudge& stamps);

/// The node's own report, and which channels' measurements come no more.
NodeReport with_stopped(NodeReport report, const std::vector<std::string>& channels);

/// Whether this is among the first words of a process: it has heard nothing yet of what is told at intervals.
bool just_started(const status_t& status);

class StatusReporter {
 public:
  StatusReporter(std::string process, Publisher& publisher);

  /// A primary input arrived; the answer to it ends the latency.
  void arrived(Utime utime, SteadyTime time);

  /// Everything since the last call.
  status_t gather(const NodeReport& node, const Inputs& inputs, Receiver& receiver);

 private:
  void answered(Utime utime);
  double rate(const std::string& key, std::int64_t now_value, double seconds);

  std::string process_;
  Publisher& publisher_;
  SteadyTime start_ = std::chrono::steady_clock::now();
  SteadyTime last_ = start_;
  double last_cpu_;
  std::map<std::string, std::int64_t> last_values_, values_;  // at the last call, and at this one
  std::map<Utime, SteadyTime> waiting_;
  std::vector<double> latencies_;  // s, the newest of them
};

}  // namespace lcmslam
