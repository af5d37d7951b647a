#pragma once
// The parts of a registration, by name. A paper is a combination of them.

#include <cstdint>
#include <string>

namespace lcmslam {

/// normal_space: equally from all directions of normals (Rusinkiewicz and Levoy 2001); stable: so that all
/// six directions of motion are fixed equally well (Gelfand et al. 2003).
enum class SelectionKind { all, uniform, random, normal_space, stable };
enum class MetricKind { point_to_point, point_to_plane, plane_to_plane };
/// What minimises the metric: closed-form estimators (thesis section 3.6, point-to-point only),
/// Gauss-Newton on SE(3), or that with Levenberg and Marquardt's damping.
enum class SolverKind {
  svd,
  svd_uncorrected,
  quaternion,
  quaternion_as_printed,
  small_angle,
  small_angle_as_printed,
  gauss_newton,
  levenberg_marquardt
};
enum class KernelKind { none, huber, geman_mcclure };

std::string to_string(MetricKind kind);
std::string to_string(SolverKind kind);
inline bool is_iterative(SolverKind kind) {
  return kind == SolverKind::gauss_newton || kind == SolverKind::levenberg_marquardt;
}

struct RegistrationSettings {
  // selection
  SelectionKind selection = SelectionKind::all;
  int selected_points = 4000;  ///< for all kinds but `all`
  std::uint64_t seed = 1;      ///< for random, normal_space and stable

  // rejection
  double max_distance = 0.3;      ///< m, of the first iteration
  double min_distance = 0.06;     ///< m; the adaptive limit does not fall below
  double distance_sigmas = 3;     ///< limit = this times the pairs' RMS distance; 0: stays at max_distance
  double max_normal_angle = 0.7;  ///< rad between both normals, where both are known; pi: off
  double trimmed_fraction = 1.0;  ///< share of the nearest pairs that is kept
  bool mutual = false;            ///< each must be the other's nearest
  bool boundary = false;          ///< reject partners where the target's surface ends
  bool frustum = false;           ///< reject points outside the target sensor's view (SensorViews)
  bool colour_overlap = false;  ///< reject points that the target's colour image does not show (SensorViews)

  // weighting
  bool weigh_by_noise = true;  ///< 1 / variance of the pair; otherwise all one
  double noise_floor = 0.004;  ///< m, added (squared) to every pair's variance: what sigmas leave out
  KernelKind kernel = KernelKind::geman_mcclure;
  double kernel_width = 2.5;  ///< standard deviations

  // metric and solver
  MetricKind metric = MetricKind::point_to_plane;
  double colour_scale = 0;  ///< m that count as much as a difference from black to white; 0: no colour term
  SolverKind solver = SolverKind::gauss_newton;
  double degenerate_share = 0.01;  ///< directions with less information than this share of what the
                                   ///< pairs could give are degenerate
  double independent_pairs = 300;  ///< neighbouring pixels share errors: more pairs add no information

  // stop
  int max_iterations = 30;
  double epsilon_translation = 5e-4;  ///< m
  double epsilon_rotation = 2e-4;     ///< rad
  double epsilon_rms = 0;             ///< m; stop when the RMS changes less (thesis algorithm 3.1); 0: off
  int min_pairs = 30;
};

}  // namespace lcmslam
