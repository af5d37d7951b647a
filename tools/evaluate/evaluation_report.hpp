#pragma once
// What `evaluate` found, as a table, as JSON and as a plot.

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/evaluation/body_offset.hpp>
#include <lcmslam/evaluation/clock_offset.hpp>
#include <lcmslam/evaluation/trajectory_plot.hpp>
#include "tools/evaluate/trajectory_inputs.hpp"

namespace lcmslam {

struct EvaluatedEstimate {
  EvaluatedPath path;
  std::optional<TrajectoryReport> report;   ///< nothing when `problem` says why
  std::optional<ClockOffset> clock;         ///< when it was asked for and found
  std::optional<TrajectoryReport> clocked;  ///< with that offset
  std::optional<BodyOffset> body;           ///< the truth speaks of another body, or of another frame on it
  bool body_aligned = false;                ///< that was taken away before the errors were measured
  std::string problem;                      ///< of the evaluation or of the search for the offset
};

struct Evaluation {
  EvaluatedPath truth;
  std::vector<EvaluatedEstimate> estimates;
  std::vector<std::string> notes;
  EvaluationSettings settings;
};

/// Evaluates every estimate; what cannot be evaluated or has no clock offset says so in `problem`.
/// `align_bodies`: a constant rotation and lever between the bodies is taken away before errors are measured.
Evaluation evaluate_all(EvaluationInputs inputs, const EvaluationSettings& settings, bool find_clock_offset,
                        const ClockOffsetSearch& search, bool align_bodies = false);

/// T_truth_map of an estimate with a report: by its aligned path, as `placed_by_poses` has it.
Eigen::Isometry3d map_place(const EvaluatedEstimate& estimate, Alignment alignment);

/// Names as on the command line.
std::string name_of(Alignment alignment);
std::string name_of(Association association);

/// Begins with the estimates that were made from ground truth, if any.
std::string format_evaluation(const Evaluation& evaluation);
nlohmann::json evaluation_json(const Evaluation& evaluation);
/// The truth and the aligned estimates from above, and the errors over time (s since the truth's first pose).
EvaluationPlot evaluation_plot(const Evaluation& evaluation);

}  // namespace lcmslam
