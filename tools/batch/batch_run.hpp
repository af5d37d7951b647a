#pragma once
// A log through the whole graph: the inputs of a log in, everything that the graph makes out.

#include <filesystem>
#include <optional>
#include <string>

#include <lcmslam/imaging/calibration.hpp>
#include "tools/batch/batch_graph.hpp"
#include "tools/batch/batch_plan.hpp"

namespace lcmslam {

struct BatchOptions {
  ConfigNode config;
  std::filesystem::path log;                   ///< .lcmlog to read
  std::filesystem::path folder;                ///< gets batch.lcmlog and the maps
  std::optional<RgbdCalibration> calibration;  ///< in the place of the log's
  double from = 0;                             ///< s from the log's start
  double to = 0;                               ///< s from the log's start, 0: its end
  int threads = 1;
  std::function<void(std::int64_t frame)> progress;  ///< frames that are done
  std::function<void(const BatchMessage&)> heard;    ///< all that goes in and comes out, in its order
};

struct BatchResult {
  std::int64_t events = 0, delivered = 0, frames = 0, published = 0;
  std::int64_t incomplete = 0;                       ///< messages in pieces of which pieces were missing
  std::size_t damages = 0;                           ///< places where the log is damaged
  std::map<std::string, std::int64_t> delivered_on;  ///< by channel
  std::map<std::string, std::int64_t> published_on;
  double log_seconds = 0;
  std::filesystem::path output;
  std::vector<BatchGraph::Summary> processes;
};

/// Why the result is not what was asked for, the first cause first: no frame, most messages of a channel
/// refused, nothing mapped, most frames mapped without odometry, maps not saved. Empty: it is.
std::vector<std::string> problems_of(const BatchResult& result);

/// Looks into the log; what cannot succeed is refused before any work (batch_plan.hpp).
BatchPlan plan_batch(const BatchOptions& options);

/// Events are logged with the time of the log's event that they follow from (the latest so far of its
/// session). Throws ConfigError and std::runtime_error.
BatchResult run_batch(const BatchOptions& options, const BatchPlan& plan);
inline BatchResult run_batch(const BatchOptions& options) {
  return run_batch(options, plan_batch(options));
}

}  // namespace lcmslam
