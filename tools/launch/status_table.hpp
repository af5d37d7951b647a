#pragma once
// The state of the whole graph from its STATUS messages.

#include <map>
#include <string>

#include <lcmslam/status_t.hpp>
#include "tools/launch/supervisor.hpp"

namespace lcmslam {

/// Newest STATUS of each process.
using StatusBoard = std::map<std::string, status_t>;

/// Takes a STATUS if it comes from one of these processes: another graph's may be on the same bus.
void take_status(StatusBoard& board, const status_t& status, const std::vector<Supervisor::State>& processes);

/// A table of 80 columns with a line for each process: state, CPU, memory, latency, losses and the oldest age
/// of a message in a queue; under it what the process waits for or says, its rates, and how good it is. Below
/// the table a line for each channel and sender with any trouble.
std::string format_status(const StatusBoard& board, const std::vector<Supervisor::State>& processes);

/// Counters of one channel summed over a process's inputs.
struct ChannelLoss {
  std::int64_t received = 0, lost = 0, duplicates = 0, reordered = 0, decode_errors = 0, queue_drops = 0;
};
ChannelLoss channel_loss(const status_t& status, const std::string& channel);
/// "running", "FAILED" ...
const char* state_name(int state);
/// One of the process's own values; 0 when it has none of that name.
double status_value(const status_t& status, const std::string& name);

}  // namespace lcmslam
