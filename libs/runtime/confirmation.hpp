#pragma once
// What ends a process or forgets its map needs a word that whoever sends it by mistake, or from an old log,
// does not know.

#include <cstdint>
#include <string>

#include <lcmslam/command_t.hpp>

namespace lcmslam {

/// "stop" and "reset".
bool needs_confirmation(const command_t& command);

/// True when the command carries the process's name among its keys, with the process's sender (status_t:
/// drawn anew at each start, so it names this run and its map) in decimals as value:
///   keys = {"icp", "fastslam"}, values = {"-8312...", "5521..."}
/// This keeps out mistakes, replays and the blind. Whoever hears the bus can read senders there.
bool is_confirmed(const command_t& command, const std::string& process, std::int64_t sender);

}  // namespace lcmslam
