#pragma once
// What a run achieved: as a table, as summary.json, as trajectories in TUM format and a plot.

#include <filesystem>
#include <string>

#include "tools/demo/run_recorder.hpp"

namespace lcmslam {

struct RunFacts {
  std::string title;  ///< e.g. "kitchen, head tof, base differential, seed 1"
  std::string config;
  double seconds = 0;               ///< wall time of the mapping
  std::vector<std::string> events;  ///< processes that ended or restarted
};

/// Frames, errors of each path against the truth, map sizes, losses.
std::string format_summary(const RunRecorder& run, const RunFacts& facts);

/// summary.json, odometry.txt, fastslam.txt, icp.txt, truth.txt (TUM format, robot frame),
/// trajectories.png. Throws std::runtime_error when a file cannot be written.
void write_run_files(const std::filesystem::path& folder, const RunRecorder& run, const RunFacts& facts);

}  // namespace lcmslam
