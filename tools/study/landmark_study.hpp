#pragma once
// Recordings of landmarks of known identity (MRCLAM, Victoria Park) through the processes that take them,
// once a seed: against the true path and map where there are any, else against the batch solution.

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/datasets/landmark_recording.hpp>
#include <lcmslam/evaluation/trajectory_error.hpp>
#include "tools/study/batch_solution.hpp"

namespace lcmslam {

/// What one run said.
struct LandmarkRun {
  Trajectory online;                                  ///< at each time, at that time
  Trajectory smoothed;                                ///< the path at the end
  std::map<std::int64_t, Eigen::Vector3d> landmarks;  ///< the map at the end
  std::map<std::string, double> report;               ///< fastslam's last STATUS values
  int restarts = 0;  ///< new maps that it began: all of this is of the newest
};

/// `config`: as a file of config/ has it; sections odometry and fastslam are used.
LandmarkRun run_landmarks(const LandmarkRecording& recording, const ConfigNode& config, int seed);

struct LandmarkScore {
  int seed = 0;
  ErrorStatistics online, smoothed;        ///< m, of positions after the best planar fit; smoothed: NaN
                                           ///< where nothing was smoothed
  std::optional<Consistency> consistency;  ///< of online
  double worst_at = 0;                     ///< s from the start, where online errs most
  double landmarks = 0;                    ///< m, RMSE, by the smoothed path's fit; NaN without a true map
  std::size_t found = 0, existing = 0;     ///< landmarks of the true map that are in ours, and all of them
  int restarts = 0;
  std::map<std::string, double> report;
};

LandmarkScore score(const LandmarkRecording& recording, const Trajectory& reference, const LandmarkRun& run,
                    int seed);

struct LandmarkStudyResult {
  std::optional<BatchSolution> batch;  ///< where the recording has no truth
  std::vector<LandmarkScore> scores;
};
LandmarkStudyResult study_landmarks(const LandmarkRecording& recording, const ConfigNode& config,
                                    const std::vector<int>& seeds);

/// Median and worst are of the runs that kept one map.
std::string landmark_table(const LandmarkStudyResult& result);
nlohmann::json landmark_json(const LandmarkStudyResult& result);

}  // namespace lcmslam
