#pragma once
// What the runs below a farm's folder achieved.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/farm/expectations.hpp"

namespace lcmslam {

struct FarmResult {
  std::string name;                               ///< of its folder
  bool has_summary = false;                       ///< it ran to its end
  std::vector<std::string> failures;              ///< why it did not pass; without a summary its last words
  std::string key;                                ///< run_key.hpp
  std::optional<double> icp, fastslam, odometry;  ///< ATE (RMSE), m; none: no truth, or not mapped
  int icp_restarts = 0, fastslam_restarts = 0;    ///< new maps that were begun: the ATE is of the newest
  double frames = 0;
  double seconds = 0;  ///< wall time

  bool passed() const { return failures.empty(); }
  /// The larger mapper's ATE over odometry's, or in m where there is no odometry: how results are ordered.
  double badness() const;
};

/// Of one run. A folder without summary.json has not ended.
FarmResult read_result(const std::filesystem::path& folder, const Expectations& expectations);

/// Of all folders below that a run has begun in, by name. Throws std::runtime_error when there is none.
std::vector<FarmResult> read_results(const std::filesystem::path& farm, const Expectations& expectations);

/// Those without a summary first, then those that failed; of either those first that lack the error of a
/// mapper which others have, though the log has a truth, the rest by badness.
void put_worst_first(std::vector<FarmResult>& results);

}  // namespace lcmslam
