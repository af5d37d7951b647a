#pragma once
// Every choice that the filter leaves open. The defaults are the modern preset; thesis_preset() is
// the filter as S. F. Husain's thesis (2010, chapter 2) describes it.

#include <cstdint>

#include <lcmslam/geometry/ground_plane.hpp>
#include <lcmslam/geometry/mount_error.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

/// Where particles are drawn from.
enum class ProposalKind {
  motion,      ///< FastSLAM 1.0: odometry and its noise (Montemerlo 2002)
  measurement  ///< FastSLAM 2.0: odometry sharpened by this step's observations (Montemerlo 2003)
};

enum class ResamplingScheme { multinomial, systematic, stratified, residual };

/// What a rejected observation does to a particle's weight.
enum class RejectionWeight {
  constant,  ///< factor p0, a density in 1/m^3 (thesis)
  floored    ///< the landmark's own density where exp(-d^2/2) equals the gate: continuous, bounded loss
};

/// Which pose is reported.
enum class PoseEstimate { best, mean };

inline constexpr Choice<ProposalKind> proposal_names[] = {{"motion", ProposalKind::motion},
                                                          {"measurement", ProposalKind::measurement}};
inline constexpr Choice<ResamplingScheme> resampling_names[] = {
    {"multinomial", ResamplingScheme::multinomial},
    {"systematic", ResamplingScheme::systematic},
    {"stratified", ResamplingScheme::stratified},
    {"residual", ResamplingScheme::residual}};
inline constexpr Choice<RejectionWeight> rejection_names[] = {{"constant", RejectionWeight::constant},
                                                              {"floored", RejectionWeight::floored}};
inline constexpr Choice<PoseEstimate> estimate_names[] = {{"best", PoseEstimate::best},
                                                          {"mean", PoseEstimate::mean}};

/// Meaning, unit and range of each stand in describe() (settings.cpp).
struct FastSlamSettings {
  // Particles.
  int particles = 100;
  std::uint64_t seed = 1;
  bool planar =
      true;  ///< pose (x, y, heading), else all six degrees of freedom; no key: the calibration tells
  /// A planar robot whose measurements refused the plane: all six degrees are free (and `planar` false), and
  /// the ground rises and falls by the way driven. No key.
  bool left_plane = false;
  GroundSettings ground;
  double ground_rise_per_m = 0.05;
  double ground_tilt_per_m = 0.3;
  ProposalKind proposal = ProposalKind::measurement;
  int proposal_iterations = 2;
  double huber_width = 2.0;
  ResamplingScheme resampling = ResamplingScheme::systematic;
  double resample_fraction = 0.5;
  PoseEstimate estimate = PoseEstimate::mean;
  // What the reported covariance is made of: where the head sits, and how the stated noise of measurements
  // goes together (sensor_error.hpp).
  MountErrorSettings mount_error;
  double draw_share = 0.05;
  double free_draw_share = 0.7;
  double systematic_depth = 0.1;
  double view_share = 0.5;
  double view_step = 0.1;
  double focal_sigma = 0.001;
  double stamp_sigma = 0.001;
  double shutter_sigma = 0;
  double slide_sigma = 0.003;
  double bend_sigma = 0.0002;

  // Motion noise of one step (standard deviations), added in variance to the odometry's own.
  bool use_motion_covariance = true;
  double translation_noise = 0.0003;
  double rotation_noise = 0.002;
  double translation_noise_per_m = 0.003;  // what is systematic is learned, below
  double rotation_noise_per_rad = 0.01;
  double rotation_noise_per_m = 0.003;
  double visual_factor = 3;

  // Systematic errors of odometry that is not visual, learned while driving (odometry_calibration.hpp):
  // what they may be at first. All 0: not learned.
  double way_scale_sigma = 0.03;
  double heading_scale_sigma = 0.02;
  double heading_per_m_sigma = 0.002;
  double side_per_m_sigma = 0.002;
  double calibration_walk = 0.05;

  // Systematic errors of a range-bearing sensor, estimated with the smoothed path (sensor_calibration.hpp):
  // what they may be. They belong to the sensor, hence to the data set's configuration. 0: none.
  double range_offset_sigma = 0;
  double range_scale_sigma = 0;
  double bearing_offset_sigma = 0;

  // Slips: many observations agree on a motion that the odometry excludes.
  bool detect_slips = true;
  double slip_gate = 20;

  // Measurements.
  double minimum_range = 0.2, maximum_range = 8;
  /// Errors of one feature are correlated in time (range wiggle, calibration), so a hundred observations say
  /// less than a hundred independent ones.
  double measurement_inflation = 2;
  double measurement_sigma = 0;
  double timing_sigma = 0.002;
  double correlation_time = 0;
  double minimum_landmark_sigma = 0.001;
  int maximum_observations = 100;

  // Association.
  double gate = 0.003;
  RejectionWeight rejection = RejectionWeight::floored;
  double p0 = 1e-3;
  double descriptor_ratio = 0.8;
  double descriptor_distance = 0.5;
  double same_place = 0.1;
  double search_radius = 0.15;
  bool guided = true;
  bool use_bearings = true;
  double visibility_margin = 0.08;
  double descriptor_blend = 0.25;
  bool verify_by_consensus = true;
  int minimum_consensus = 8;
  bool close_loops = true;
  int loop_steps = 3;
  int relocalise_after = 5;
  double lost_after = 0.25;

  // Landmarks of known identity in the plane: the path so far is smoothed when a landmark comes into sight
  // again after long or is contradicted, or few lineages are left, and the particles are drawn anew from its
  // posterior (path_smoother.hpp).
  bool rejuvenate = true;
  double rejuvenation_share = 0.2;
  double rejuvenation_lineages = 0.25;
  int reunion_steps = 20;

  // Keyframes of 3-D landmarks, so that path and map can be smoothed on request (map_smoother.hpp).
  bool smooth_map = true;
  bool bend_closed_loops = false;  // off: it brings nothing so far (docs/notebook/graph.md)

  // New landmarks and their existence (log-odds).
  int maximum_new_landmarks = 60;
  int cell_capacity = 3;
  bool remove_landmarks = true;
  double odds_hit = 1.0, odds_miss = -0.3, odds_new = 0.0, odds_remove = -1.0, odds_maximum = 6.0;
  int minimum_observations = 3;
  int tentative_steps = 50;

  void describe(SettingsVisitor& s);
};

/// The thesis: planar, 1.0, sigma_r = 0.05 m, independent draws in every step, the nearest descriptor of the
/// whole map tells the landmark, what is new or rejected by the best particle becomes one, nothing dies.
FastSlamSettings thesis_preset();

/// Throws std::invalid_argument naming the setting, its value and what would be right.
void check(const FastSlamSettings& settings);

}  // namespace lcmslam
