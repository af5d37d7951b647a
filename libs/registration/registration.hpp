#pragma once
// Registration of a cloud to a target: the iterative closest point algorithm (thesis algorithm 3.1)
// with exchangeable parts (after the taxonomy of Rusinkiewicz and Levoy 2001): select, then repeat
// find pairs, reject, weigh, solve until nothing moves any more.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/registration/rejection.hpp>
#include <lcmslam/registration/solver.hpp>
#include <lcmslam/registration/target.hpp>

namespace lcmslam {

enum class StopReason {
  converged,  ///< the last step was below epsilon
  max_iterations,
  too_few_pairs,  ///< nothing to register: T is where the last good step led
  degenerate      ///< the pairs give no step at all
};
std::string to_string(StopReason reason);

/// What pairs with settled surfaces alone say of a motion about T_target_source (right perturbation), without
/// a prior: information * xi = gradient.
struct SettledPairs {
  Matrix6d information = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
};

struct RegistrationResult {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();  ///< always finite
  Matrix6d covariance = Matrix6d::Identity();  ///< of T_target_source, right perturbation
  std::vector<double> rms;  ///< m, of the metric's residual over the kept pairs, each iteration
  int pairs = 0;            ///< kept in the last iteration
  int inliers = 0;          ///< of them, with a residual below three standard deviations
  double overlap = 0;       ///< kept pairs / selected points, 0..1
  Vector6d observability = Vector6d::Zero();  ///< share of the information, ascending (Observability::shares)
  std::vector<Vector6d> degenerate;           ///< unit twists (translation, rotation), source frame
  StopReason stop = StopReason::too_few_pairs;
  std::optional<SettledPairs> settled;  ///< where they lead (RegistrationSettings::settled_lead)
  bool ok() const { return stop == StopReason::converged || stop == StopReason::max_iterations; }
};

/// For each degenerate direction the axis of the source frame that has most of it: x, y, z, roll, pitch, yaw.
std::vector<std::string> degenerate_names(const RegistrationResult& result);

/// T_target_source from a start. Throws std::invalid_argument for combinations of parts that do not
/// exist (make_solver), never for data: clouds that are empty, not finite or degenerate give a stop
/// reason and the start (or the last good) transform. `views` is asked for by the frustum and the colour
/// overlap rejector alone. `noise_left` of the source's sigmas (DepthFilter::noise_left) weighs its pairs in
/// the last step. Sources need what the settings ask for (prepared_source): normals for plane-to-plane, ...
RegistrationResult register_cloud(const Cloud& source, const Target& target, const Eigen::Isometry3d& T_start,
                                  const RegistrationSettings& settings, const Prior* prior = nullptr,
                                  const SensorViews* views = nullptr, double noise_left = 1);

/// What register_cloud would report at T, without a step: pairs within max_distance, RMS, covariance,
/// overlap. Stop is converged, or too_few_pairs.
RegistrationResult look(const Cloud& source, const Target& target, const Eigen::Isometry3d& T,
                        const RegistrationSettings& settings);

/// The whole way from two clouds: prepares both for the passes' settings (view points: the origins), builds a
/// k-d tree of the target and runs the passes, each from the last one's result. Throws like register_cloud,
/// and for no passes.
RegistrationResult register_clouds(const Cloud& source, const Cloud& target, const Eigen::Isometry3d& T_start,
                                   const std::vector<RegistrationSettings>& passes);

/// Two passes for clouds that start up to about half a metre apart: few points from far, then many.
std::vector<RegistrationSettings> wide_passes(MetricKind metric = MetricKind::point_to_plane);

}  // namespace lcmslam
