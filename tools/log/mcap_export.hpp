#pragma once
// Logs as an MCAP file of ROS 2's messages, which other people's viewers open.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tools/log/log_edit.hpp"

namespace lcmslam {

struct McapExport {
  std::map<std::string, std::int64_t> topics;               ///< messages written
  std::map<std::string, std::int64_t> without_counterpart;  ///< messages by channel: ROS has none like them
  std::map<std::string, std::int64_t> undecoded;            ///< messages by channel: damaged
  std::vector<LogDamage> damages;                           ///< of the logs
  std::uint64_t bytes = 0;
};

/// docs/ROS.md says which message becomes which. Several logs of one drive (the recording and batch's
/// results) become one file by log time; a channel that several have is taken from the first. `compression`
/// of chunks: "zstd", "lz4" or "none". Throws std::runtime_error, and writes nothing, when the output exists,
/// is an input, nothing can be exported, or a signal asks to stop.
McapExport export_mcap(const std::vector<std::string>& logs, const LogOutput& output,
                       const std::string& compression);

}  // namespace lcmslam
