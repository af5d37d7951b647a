#pragma once
// The parts of a registration, by name. A paper is a combination of them.

#include <cstdint>
#include <string>

#include <lcmslam/settings/settings.hpp>

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

inline constexpr Choice<SelectionKind> selection_names[] = {{"all", SelectionKind::all},
                                                            {"uniform", SelectionKind::uniform},
                                                            {"random", SelectionKind::random},
                                                            {"normal_space", SelectionKind::normal_space},
                                                            {"stable", SelectionKind::stable}};
inline constexpr Choice<MetricKind> metric_names[] = {{"point_to_point", MetricKind::point_to_point},
                                                      {"point_to_plane", MetricKind::point_to_plane},
                                                      {"plane_to_plane", MetricKind::plane_to_plane}};
inline constexpr Choice<SolverKind> solver_names[] = {
    {"svd", SolverKind::svd},
    {"svd_uncorrected", SolverKind::svd_uncorrected},
    {"quaternion", SolverKind::quaternion},
    {"quaternion_as_printed", SolverKind::quaternion_as_printed},
    {"small_angle", SolverKind::small_angle},
    {"small_angle_as_printed", SolverKind::small_angle_as_printed},
    {"gauss_newton", SolverKind::gauss_newton},
    {"levenberg_marquardt", SolverKind::levenberg_marquardt}};
inline constexpr Choice<KernelKind> kernel_names[] = {
    {"none", KernelKind::none}, {"huber", KernelKind::huber}, {"geman_mcclure", KernelKind::geman_mcclure}};

struct RegistrationSettings {
  // selection
  SelectionKind selection = SelectionKind::all;
  int selected_points = 4000;
  std::uint64_t seed = 1;

  // rejection
  double max_distance = 0.3;
  double min_distance = 0.06;
  double distance_sigmas = 3;
  double max_normal_angle = 0.7;
  double trimmed_fraction = 1.0;
  bool mutual = false;
  bool boundary = false;
  bool frustum = false;
  bool colour_overlap = false;

  // weighting
  bool weigh_by_noise = true;
  double noise_floor = 0.004;
  KernelKind kernel = KernelKind::geman_mcclure;
  double kernel_width = 2.5;
  bool settled_lead = false;  ///< young surfaces only where there are no others; no key: the mapper tells

  bool settled_alone = false;  ///< young surfaces have no pairs; no key, either

  // metric and solver
  MetricKind metric = MetricKind::point_to_plane;
  double colour_scale = 0;
  SolverKind solver = SolverKind::gauss_newton;
  double degenerate_share = 0.01;
  double independent_pairs = 300;

  // stop
  int max_iterations = 30;
  double epsilon_translation = 5e-4;
  double epsilon_rotation = 2e-4;
  double epsilon_rms = 0;
  int min_pairs = 30;

  /// What every registration has.
  void describe(SettingsVisitor& s) {
    s.choice("selection", selection, selection_names, "which points of the source take part");
    s.number("selected_points", selected_points, "", {10, 1e7},
             "points of the source that take part, for all selections but `all`");
    s.number("seed", seed, "", {0, 1e9}, "of the draws, for random, normal_space and stable");
    s.number("max_distance", max_distance, "m", {0, 1000}, "of a pair, in the first iteration");
    s.number("min_distance", min_distance, "m", {0, 1000},
             "the adaptive limit of a pair does not fall below");
    s.number("distance_sigmas", distance_sigmas, "", {0, 1e6},
             "the adaptive limit over the pairs' RMS distance; 0: it stays at max_distance");
    s.number("max_normal_angle", max_normal_angle, "rad", {0, 3.2},
             "between both normals of a pair, where both are known; pi: any");
    s.number("trimmed_fraction", trimmed_fraction, "", {0, 1}, "share of the nearest pairs that is kept");
    s.flag("mutual", mutual, "each point of a pair must be the other's nearest");
    s.flag("boundary", boundary, "rejects partners where the target's surface ends");
    s.flag("weigh_by_noise", weigh_by_noise,
           "weighs a pair by the inverse of its variance; otherwise all alike");
    s.number("noise_floor", noise_floor, "m", {0, 1000},
             "added (squared) to every pair's variance: what the sigmas leave out");
    s.choice("kernel", kernel, kernel_names, "robust kernel on the residuals");
    s.number("kernel_width", kernel_width, "standard deviations", {0.01, 1e6}, "of the robust kernel");
    s.choice("metric", metric, metric_names, "what is minimised");
    s.choice("solver", solver, solver_names,
             "what minimises it: closed forms (point_to_point alone), Gauss-Newton, or Levenberg-Marquardt");
    s.number("degenerate_share", degenerate_share, "", {0, 1},
             "directions with less information than this share of what the pairs could give are degenerate");
    s.number("independent_pairs", independent_pairs, "", {1, 1e9},
             "neighbouring pixels share errors: more pairs than these add no information");
    s.number("max_iterations", max_iterations, "", {1, 10000}, "iterations after which registration stops");
    s.number("epsilon_translation", epsilon_translation, "m", {0, 1000},
             "stops when a step moves less, and turns less than epsilon_rotation");
    s.number("epsilon_rotation", epsilon_rotation, "rad", {0, 3.1416},
             "stops when a step turns less, and moves less than epsilon_translation");
    s.number("min_pairs", min_pairs, "", {1, 1e6}, "fewer pairs are a failure");
    s.require(is_iterative(solver) || (metric == MetricKind::point_to_point && colour_scale <= 0), "solver",
              "must be gauss_newton or levenberg_marquardt: a closed form minimises point_to_point without "
              "colour alone");
  }

  /// And what asks for views, images and colours of the target (SensorViews).
  void describe_pass(SettingsVisitor& s) {
    s.number("epsilon_rms", epsilon_rms, "m", {0, 1000},
             "stops when the RMS error changes less (thesis algorithm 3.1); 0: off");
    s.flag("frustum", frustum, "rejects points outside the target sensor's view");
    s.flag("colour_overlap", colour_overlap, "rejects points that the target's colour image does not show");
    s.number("colour_scale", colour_scale, "m", {0, 1000},
             "that count as much as a difference from black to white; 0: no colour term");
    describe(s);
  }
};

}  // namespace lcmslam
