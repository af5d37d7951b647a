#pragma once
// How far an estimated trajectory is from the truth: absolute trajectory error (ATE) and relative pose
// error (RPE) as J. Sturm et al. define them ("A benchmark for the evaluation of RGB-D SLAM systems",
// IROS 2012).
//
//   associate -> find_alignment -> align -> absolute_errors, relative_errors
//
// `evaluate` does all of it. Both trajectories must speak of the same body frame (in_other_frame).

#include <optional>
#include <string>
#include <vector>

#include <lcmslam/evaluation/trajectory.hpp>

namespace lcmslam {

enum class Association {
  nearest,           ///< TUM's: nearest stamps, one to one, best pairs first
  interpolate_truth  ///< the truth is interpolated at every stamp of the estimate
};

/// What is taken away before errors are measured: the transform that fits the estimate's positions to
/// the truth's best (least squares), from the named group.
enum class Alignment {
  none,        ///< both are in the same world frame
  first_pose,  ///< the first matched pose is made to agree
  se2,         ///< heading, x and y: worlds that share the ground plane
  se3,         ///< TUM's
  sim3         ///< with scale: monocular estimates (Umeyama 1991)
};

struct EvaluationSettings {
  Association association = Association::nearest;
  double max_time_difference = 0.02;  ///< s; nearest: pairs must be closer than this;
                                      ///< interpolate_truth: largest gap of the truth is 10 times this
  double clock_offset = 0;            ///< s, added to the estimate's stamps gives the truth's clock
  Alignment alignment = Alignment::se3;
  bool fit_body = false;          ///< where covariances are judged, fits where the truth's body sits
  double max_tracking_gap = 1.0;  ///< s; matched poses further apart are lost track between them, and three
                                  ///< usual steps where truth or estimate come seldom
};

struct MatchedPose {
  Utime utime = 0;  ///< of the truth's clock, at the estimate's pose
  Eigen::Isometry3d T_world_truth = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_world_estimate = Eigen::Isometry3d::Identity();
  std::optional<Matrix6d> covariance = std::nullopt;  ///< the estimate's own, as in StampedPose
};

/// p_truth = scale * T * p_estimate (T's translation is not scaled).
struct WorldAlignment {
  double scale = 1;
  Eigen::Isometry3d T_truth_estimate = Eigen::Isometry3d::Identity();
};

/// NaN everywhere where count is 0.
struct ErrorStatistics {
  std::size_t count = 0;
  double rmse = 0, mean = 0, median = 0, maximum = 0;
};

struct PoseErrors {
  ErrorStatistics translation;  ///< m
  ErrorStatistics rotation;     ///< rad
};

/// Whether the estimate errs as much as it says (consistency.hpp).
struct Consistency {
  int components = 6;          ///< of a pose's error: what NEES averages to when the covariances are honest
  ErrorStatistics nees;        ///< normalised estimation error squared
  double inside = 0;           ///< share of the poses that err less than their covariance's 95 % bound
  double position_inside = 0;  ///< the same of their positions
  std::vector<double>
      error_over_sigma;  ///< RMS of each component: x, y, z, roll, pitch, yaw (body), or x, y, yaw
  Eigen::Isometry3d T_estimate_truth = Eigen::Isometry3d::Identity();  ///< the truth's body, where fitted
};

/// Step of the relative pose error.
enum class StepUnit { frames, seconds, metres };

struct TrajectoryReport {
  std::size_t truth_poses = 0, estimate_poses = 0, matched_poses = 0;
  double tracking_gap = 0;      ///< s, that was allowed: max_tracking_gap, or three usual steps
  double tracked_fraction = 0;  ///< time between matched poses that are no further apart than tracking_gap,
                                ///< by the same time of the truth's poses; NaN where these have none
  double truth_length = 0;      ///< m, path through the matched poses
  WorldAlignment alignment;
  PoseErrors absolute;                          ///< ATE, and the rotation left after alignment
  PoseErrors per_frame, per_second, per_metre;  ///< RPE over 1 frame, 1 s and 1 m of path
  std::optional<Consistency> consistency;       ///< where the estimate has covariances
  std::vector<MatchedPose> matches;             ///< aligned
};

/// Pairs in order of time. Throws std::invalid_argument, with both time spans, when nothing matches.
std::vector<MatchedPose> associate(const Trajectory& truth, const Trajectory& estimate,
                                   const EvaluationSettings& settings = {});

/// Throws std::invalid_argument when there are no matches, or for sim3 when the estimate stands still.
WorldAlignment find_alignment(const std::vector<MatchedPose>& matches, Alignment alignment);
Eigen::Isometry3d apply(const WorldAlignment& alignment, const Eigen::Isometry3d& T_world_estimate);
/// The matches with the estimate moved into the truth's world.
std::vector<MatchedPose> align(std::vector<MatchedPose> matches, const WorldAlignment& alignment);

PoseErrors absolute_errors(const std::vector<MatchedPose>& matches);

/// For each match i the match j whose distance from i is nearest to `step` (within 10 % of it; frames
/// exactly, metres along the true path): E = (truth_i^-1 truth_j)^-1 (estimate_i^-1 estimate_j).
/// Errors are those of the whole step, not divided by its length.
PoseErrors relative_errors(const std::vector<MatchedPose>& matches, double step, StepUnit unit);

ErrorStatistics statistics(std::vector<double> errors);

/// Throws std::invalid_argument when nothing matches, or too little for the alignment.
TrajectoryReport evaluate(const Trajectory& truth, const Trajectory& estimate,
                          const EvaluationSettings& settings = {});

}  // namespace lcmslam
