#pragma once
// The filter alone over logs with images, once a seed: features are found once a log, then odometry and
// fastslam run as often as asked. Answers: how far is the path from the truth, how far are landmarks from the
// scene's true surfaces, does a thing seen first and last coincide, and how much of a noise that was added to
// the odometry (odometry.noise, thesis figure 2.10) does the filter take away.

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/evaluation/trajectory_error.hpp>
#include <lcmslam/features/feature.hpp>
#include "tools/batch/batch_graph.hpp"

namespace lcmslam {

/// A log with features in place of its images.
struct PreparedLog {
  std::vector<BatchMessage> messages;  ///< what odometry and fastslam take, in the log's order
  std::vector<FeatureFrame> frames;
  Trajectory truth;  ///< of the robot
};
/// Of the configuration without `odometry.noise`, whose mode it sets to none in all its copies. Throws
/// std::runtime_error for a log without images or truth.
PreparedLog prepare_log(const std::string& log, const ConfigNode& config, int threads);

struct FilterRun {
  Trajectory odometry, fastslam, smoothed;
  struct Landmark {
    Eigen::Vector3d mean;        ///< m, in the map
    Eigen::Matrix3d covariance;  ///< m^2
  };
  std::vector<Landmark> landmarks;  ///< fastslam's map
  int lost = 0;                     ///< fastslam's poses of that status, of all its maps
  int restarts = 0;                 ///< new maps that it began: paths and landmarks are of the newest
};
FilterRun run_filter(const PreparedLog& log, const ConfigNode& config, int seed);

/// How far features seen early and seen again late from about the same place lie from each other when each
/// is placed by the path's pose of its own time, m. Which are the same is decided by descriptors and checked
/// by the true poses. Empty when the path does not come back.
std::vector<double> reunion_distances(const std::vector<FeatureFrame>& frames, const Trajectory& truth,
                                      const Trajectory& path);

/// m, from a point of the truth's world to the nearest surface.
using SurfaceDistance = std::function<double(const Eigen::Vector3d&)>;

/// Part of all frames' points, each placed by the true pose of its time, that lie on a surface to three of
/// their sigmas (point_covariance()) along its normal; of those within 0.2 m of one. NaN without any.
double features_inside(const std::vector<FeatureFrame>& frames, const Trajectory& truth,
                       const SurfaceDistance& surface);

struct FilterScore {
  std::string log;
  int seed = 0;
  double odometry = 0, fastslam = 0, smoothed = 0;  ///< ATE RMSE, m
  double clean = 0, corrected = 0;          ///< odometry's ATE without noise; part of the noise's error taken
                                            ///< away: (odometry - fastslam) / (odometry - clean)
  double landmarks = 0, landmarks_p90 = 0;  ///< median and 90 % of their distances from surfaces, m
  double nees = 0, beyond = 0;              ///< of fastslam: mean; share of poses beyond their 95 % bound
  double reunion = 0, odometry_reunion = 0;  ///< medians of reunion_distances, m
  double landmarks_inside = 0;  ///< part of them that lie on a surface to three of their sigmas along its
                                ///< normal, where the first pose says where the map lies
  double features_inside = 0;
  int reunions = 0, lost = 0, restarts = 0;
};

/// `clean`: ATE of the odometry without added noise, or NaN. NaN in what cannot be known.
FilterScore score_filter(const PreparedLog& log, const FilterRun& run, double clean,
                         const SurfaceDistance& surface);

/// Each log with each seed; without seeds once, with the seed of the configuration.
std::vector<FilterScore> study_filter(const std::vector<std::string>& logs, const ConfigNode& config,
                                      const std::vector<int>& seeds, const SurfaceDistance& surface);

/// Median and worst are of the runs that kept one map: an error of the newest alone says little of the log.
std::string filter_table(const std::vector<FilterScore>& scores);
nlohmann::json filter_json(const std::vector<FilterScore>& scores);

}  // namespace lcmslam
