#pragma once
// The four resampling schemes on one recording: how well the path is found, and how many different particles
// are left after each step. Images are turned into features once, the filter then runs for every preset,
// scheme and seed.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace lcmslam {

struct ResamplingStudySettings {
  std::filesystem::path log;           ///< with GROUND_TRUTH, and CAMERA or FEATURES and ODOMETRY
  std::string config;                  ///< as for batch
  std::vector<std::string> overrides;  ///< section.key=value
  std::vector<int> seeds;              ///< of the filter
};

struct ResamplingScore {
  std::string preset, scheme;
  int seed = 0;
  double ate = 0;                    ///< m, RMSE of FASTSLAM_POSE
  double distinct = 0;               ///< mean number of different particles after a step
  double effective_sample_size = 0;  ///< mean, before resampling
  int lost = 0, restarts = 0;        ///< poses of that status, of all maps; new maps that were begun
};

/// Works in `folder`. Throws ConfigError and std::runtime_error.
std::vector<ResamplingScore> study_resampling(const ResamplingStudySettings& settings,
                                              const std::filesystem::path& folder);

/// A row for each preset and scheme: median and worst ATE over the seeds that kept one map, means of the
/// counts.
std::string resampling_table(const std::vector<ResamplingScore>& scores);
nlohmann::json resampling_json(const std::vector<ResamplingScore>& scores);

}  // namespace lcmslam
