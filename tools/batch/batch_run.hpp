#pragma once
// A log through the whole graph: the inputs of a log in, everything that the graph makes out.

#include <filesystem>
#include <optional>
#include <string>

#include "tools/batch/batch_graph.hpp"

namespace lcmslam {

struct BatchOptions {
  ConfigNode config;
  std::filesystem::path log;     ///< .lcmlog to read
  std::filesystem::path folder;  ///< gets batch.lcmlog and the maps
  double from = 0;               ///< s from the log's start
  double to = 0;                 ///< s from the log's start, 0: its end
  int threads = 1;
  std::function<void(double seconds)> progress;    ///< s of log time that are done
  std::function<void(const BatchMessage&)> heard;  ///< all that goes in and comes out, in its order
};

struct BatchResult {
  std::int64_t events = 0, delivered = 0, frames = 0, published = 0;
  std::int64_t incomplete = 0;                       ///< messages in pieces of which pieces were missing
  std::size_t damages = 0;                           ///< places where the log is damaged
  std::map<std::string, std::int64_t> delivered_on;  ///< by channel
  double log_seconds = 0;
  std::filesystem::path output;
  std::vector<BatchGraph::Summary> processes;
};

/// Why the result is not what was asked for, the first cause first: no frame, nothing mapped, most messages
/// of a channel refused, maps not saved. Empty: it is.
std::vector<std::string> problems_of(const BatchResult& result);

/// Events are logged with the time of the log's event that they follow from (the latest so far of its
/// session). Throws ConfigError and std::runtime_error.
BatchResult run_batch(const BatchOptions& options);

}  // namespace lcmslam
