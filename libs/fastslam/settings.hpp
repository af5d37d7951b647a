#pragma once
// Every choice that the filter leaves open. The defaults are the modern preset; thesis_preset() is
// the filter as S. F. Husain's thesis (2010, chapter 2) describes it.

#include <cstdint>

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

struct FastSlamSettings {
  // Particles.
  int particles = 100;
  std::uint64_t seed = 1;
  bool planar = true;  ///< pose (x, y, heading); otherwise all six degrees of freedom
  ProposalKind proposal = ProposalKind::measurement;
  int proposal_iterations = 2;  ///< Gauss-Newton steps of the 2.0 proposal
  double huber_width = 2.0;     ///< residuals beyond this many sigma lose influence on the proposal
  ResamplingScheme resampling = ResamplingScheme::systematic;
  double resample_fraction = 0.5;  ///< resample when ESS < fraction * particles; 1 or more: every step
  PoseEstimate estimate = PoseEstimate::mean;
  // Added in variance to the reported covariance: what no particle knows of (the depth's systematic errors,
  // the camera's mount). What all particles share of the past is told apart from it (shared_error.hpp).
  double shared_translation_sigma = 0.006;  ///< m
  double shared_rotation_sigma = 0.0025;    ///< rad

  // Motion noise of one step (standard deviations), added in variance to the odometry's own.
  bool use_motion_covariance = true;      ///< false: the noise is only what stands below
  double translation_noise = 0.003;       ///< m
  double rotation_noise = 0.002;          ///< rad
  double translation_noise_per_m = 0.01;  ///< m per metre driven; what is systematic is learned, below
  double rotation_noise_per_rad = 0.01;   ///< rad per radian turned
  double rotation_noise_per_m = 0.003;    ///< rad per metre driven
  double visual_factor = 3;  ///< sigma of visual odometry times this: it was made from the same features

  // Systematic errors of odometry that is not visual, learned while driving (odometry_calibration.hpp):
  // what they may be at first. All 0: not learned.
  double way_scale_sigma = 0.03;       ///< ratio
  double heading_scale_sigma = 0.02;   ///< ratio
  double heading_per_m_sigma = 0.002;  ///< rad per metre driven
  double calibration_walk = 0.05;      ///< of these sigmas per root metre: how fast they may change

  // Systematic errors of a range-bearing sensor, estimated with the smoothed path (sensor_calibration.hpp):
  // what they may be. They belong to the sensor, hence to the data set's configuration. 0: none.
  double range_offset_sigma = 0;    ///< m
  double range_scale_sigma = 0;     ///< ratio
  double bearing_offset_sigma = 0;  ///< rad

  // Slips: many observations agree on a motion that the odometry excludes.
  bool detect_slips = true;
  double slip_gate = 20;  ///< squared Mahalanobis distance of that motion from the odometry's

  // Measurements.
  double minimum_range = 0.2, maximum_range = 8;  ///< m, of 3-D points used
  /// Factor on each measurement covariance. Errors of one feature are correlated in time (range
  /// wiggle, calibration), so a hundred sights say less than a hundred independent ones.
  double measurement_inflation = 2;
  /// s over which a sensor's errors on one landmark stay alike (their autocorrelation falls to 1/e);
  /// 0: independent from frame to frame. Belongs to the sensor, hence to the data set's configuration.
  double correlation_time = 0;
  double minimum_landmark_sigma = 0.001;  ///< m, added in variance after an update: never certain
  int maximum_observations = 100;         ///< used per step, spread over the image, best known first

  // Association.
  double gate = 0.003;  ///< an observation belongs to its landmark when exp(-d^2/2) >= gate (2.5)
  RejectionWeight rejection = RejectionWeight::floored;
  double p0 = 1e-3;                  ///< 1/m^3, for RejectionWeight::constant
  double descriptor_ratio = 0.8;     ///< best distance / second best distance
  double descriptor_distance = 0.5;  ///< largest distance of unit descriptors
  double same_place = 0.1;           ///< m, nearer landmarks are no rivals in the ratio test
  double search_radius = 0.15;       ///< of the image width, around the predicted pixel after a slip
  bool guided = true;                ///< landmarks are sought where they should be seen; false: by descriptor
                                     ///< alone, in the whole map (thesis 2.3.2)
  bool use_bearings = true;          ///< features without depth measure known landmarks
  double visibility_margin = 0.08;   ///< of the image width, beyond the border
  double descriptor_blend = 0.25;    ///< of the newest descriptor in the landmark's; 0: the first stays
  bool verify_by_consensus = true;   ///< drop matches that no common pose explains
  int minimum_consensus = 8;         ///< matches that must agree for a pose to be believed
  bool close_loops = true;           ///< by place recognition in the whole map
  int loop_steps = 3;        ///< steps in a row that must recognise a place before the pose jumps there
  int relocalise_after = 5;  ///< steps without consensus before the whole map is searched

  // Landmarks of known identity in the plane: the path so far is smoothed when a landmark comes into sight
  // again after long or is contradicted, or few lineages are left, and the particles are drawn anew from its
  // posterior (path_smoother.hpp).
  bool rejuvenate = true;
  double rejuvenation_share = 0.2;      ///< of a core's time for the solver; twice that at few lineages
  double rejuvenation_lineages = 0.25;  ///< of the particles: distinct ancestors since they were drawn anew
  int reunion_steps = 20;               ///< unseen for so many steps is long

  /// Keep keyframes of 3-D landmarks, so that path and map can be smoothed on request (map_smoother.hpp).
  bool smooth_map = true;
  /// Smooth them unasked, too, when a loop was closed. Off: fr1_rpy's online error grew by it.
  bool bend_closed_loops = false;

  // New landmarks and their existence (log-odds).
  int maximum_new_landmarks = 60;  ///< a step
  int cell_capacity = 3;           ///< landmarks seen in one of 16 x 12 image cells before no more are made
  bool remove_landmarks = true;
  double odds_hit = 1.0, odds_miss = -0.3, odds_new = 0.0, odds_remove = -1.0, odds_maximum = 6.0;
  int minimum_observations = 3;  ///< before a landmark is given out
  int tentative_steps = 50;      ///< a landmark not given out and not seen for so many steps is forgotten
};

/// The thesis: planar, 1.0, sigma_r = 0.05 m, independent draws in every step, the nearest descriptor of the
/// whole map tells the landmark, what is new or rejected by the best particle becomes one, nothing dies.
FastSlamSettings thesis_preset();

/// Throws std::invalid_argument naming the setting, its value and what would be right.
void check(const FastSlamSettings& settings);

}  // namespace lcmslam
