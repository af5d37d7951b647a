#pragma once
// What a run achieved, the same for demo, launch and batch: as a table, as summary.json, as trajectories in
// TUM format (or KITTI's too) and a plot.

#include <filesystem>
#include <string>

#include "tools/demo/run_recorder.hpp"

namespace lcmslam {

struct RunFacts {
  std::string title;                   ///< e.g. "kitchen, head tof, base differential, seed 1"
  std::string config;                  ///< file
  std::string configuration = "null";  ///< what it said when the run began (config_json())
  std::vector<std::string> overrides;  ///< --set
  double frames = -1;                  ///< of the camera; -1: as its STATUS says
  bool kitti = false;                  ///< trajectories in KITTI's format too
  double seconds = 0;                  ///< wall time of the mapping
  std::vector<std::string> events;     ///< processes that ended or restarted
  std::string key;                     ///< of a farm: by which it knows its own results; may be empty
};

/// Each path's errors against the truth, and why one has none. Empty without a truth.
std::string format_errors(const RunRecorder& run);

/// Frames, errors of each path against the truth, map sizes, losses.
std::string format_summary(const RunRecorder& run, const RunFacts& facts);

/// odometry.txt, fastslam.txt, icp.txt, truth.txt (TUM format, robot frame), trajectories.png, and last of
/// all summary.json (errors, processes, versions, the configuration and the calibration; but for its `timing`
/// and the live processes' load a run's repetition has the same). Throws std::runtime_error when a file
/// cannot be written.
void write_run_files(const std::filesystem::path& folder, const RunRecorder& run, const RunFacts& facts);

}  // namespace lcmslam
