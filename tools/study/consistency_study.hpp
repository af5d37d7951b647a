#pragma once
// Whether mappers err as much as they say, in the frame in which they say it: a pose with its covariance
// stands in the map's frame, which is the robot's first pose, so the truth is laid on the estimate's first
// pose and nowhere else. (A fit of the whole paths would take away the very error that grows with the way.)
//
//   e = log(T_map_estimate^-1 T_map_truth),   NEES = e^T P^-1 e     (body frame, as pose_estimate_t says)
//
// Logs of one scene (kitchen_1.lcmlog, kitchen_2.lcmlog, ...) are runs of one drive. In each second the NEES
// of N runs is averaged; N times that mean is chi-square with N d degrees of freedom when P is honest
// (Bar-Shalom, Li and Kirubarajan 2001, 5.4.2). Poses of one second err alike and count as one.
//
// Beside the mappers' poses at their time, the keyframes of 6-D SLAM's map as its graph has them at the end
// (ICP_GRAPH and its covariances), the first one laid on the truth. Of normal errors 99.7 % are within three
// of their sigmas: of each component by its own, and of the whitened ones, P^-1/2 e, together.

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/evaluation/trajectory_error.hpp>
#include "tools/study/believed_poses.hpp"

namespace lcmslam {

/// One mapper's NEES in one run.
struct ConsistencyRun {
  std::string scene, log, channel;
  int components = 6;                 ///< 3: a path in the plane, by (x, y, heading)
  std::vector<double> nees;           ///< mean of each second since the first pose, NaN without poses
  std::vector<double> all;            ///< of each pose
  std::array<double, 6> ratio_rms{};  ///< RMS of each component's error over its own sigma: 1 when honest
  std::array<double, 6> error_rms{};  ///< m, rad
  std::array<double, 6> within{};     ///< share of each component's errors within three sigmas
  double within_whitened = 0;         ///< and of all whitened ones
  std::size_t left_out = 0;           ///< poses that are not believed, have no true one, or do not say by how
                                      ///< much they err
};

/// Several runs of one scene together.
struct ConsistencyScore {
  std::string scene, channel;
  int runs = 0;                         ///< that have a pose to judge; without any all figures are NaN
  std::vector<std::string> not_judged;  ///< logs of the others
  double components = 0;                ///< NEES when honest: the runs' mean, as one may leave the plane
  double low = 0, high = 0;             ///< 95 % band of the mean of so many runs
  std::size_t seconds = 0;              ///< of the longest run
  std::size_t judged = 0;               ///< seconds of which all runs have a pose
  double inside = 0, above = 0;         ///< share of those; NaN without any, as far_above
  double far_above = 0;         ///< share of those whose mean is more than three times its expectation
  double mean = 0, median = 0;  ///< of all poses' NEES
  std::array<double, 6> ratio_rms{}, error_rms{};
  std::array<double, 6> within{};  ///< of all poses that have the component, likewise
  double within_whitened = 0;
  std::size_t poses = 0, left_out = 0;
};

/// The poses' NEES against the truth; `matches` in the order of time, in their own worlds, the first one
/// where the map begins.
ConsistencyRun consistency_run(const std::vector<MatchedPose>& matches);

/// The same, of those that have a true pose; none of them: a run without any NEES. The rest is left out.
ConsistencyRun consistency_run(const Trajectory& truth, const BelievedPath& believed,
                               const EvaluationSettings& settings);

/// Quantile of chi square. `normal_quantile`: that of the standard normal distribution, 1.96 for 97.5 %.
double chi_square_quantile(double degrees, double normal_quantile);

std::vector<ConsistencyScore> consistency_scores(const std::vector<ConsistencyRun>& runs);

struct ConsistencyRuns {
  std::vector<ConsistencyRun> runs;
  std::vector<std::string> left_out;  ///< logs that cannot be judged (without truth): "NAME: why"
};

/// Each log through batch, with `config`, into `folder`. `clock_offset`: s, added to images' stamps for the
/// truth's clock. Throws std::runtime_error where no log can be judged, and for a log that is named twice.
ConsistencyRuns study_consistency(const std::vector<std::string>& logs, const ConfigNode& config,
                                  const std::string& folder, double clock_offset);

std::string consistency_table(const std::vector<ConsistencyScore>& scores);
/// Shares of errors within three sigmas.
std::string within_table(const std::vector<ConsistencyScore>& scores);
nlohmann::json consistency_json(const std::vector<ConsistencyRun>& runs,
                                const std::vector<ConsistencyScore>& scores);

}  // namespace lcmslam
