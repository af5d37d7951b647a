#include <lcmslam/fastslam/settings.hpp>

#include <limits>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {
FastSlamSettings thesis_preset() {
  FastSlamSettings s;
  s.planar = true;
  s.proposal = ProposalKind::motion;
  s.resampling = ResamplingScheme::multinomial;
  s.resample_fraction = 1;
  s.estimate = PoseEstimate::best;
  s.draw_share = s.free_draw_share = 1;  // the best particle errs by its own draws
  s.use_motion_covariance = false;
  s.translation_noise = 0.05;  // sigma_r of figure 2.1; its heading's noise is not given
  s.rotation_noise = 0.01;
  s.translation_noise_per_m = s.rotation_noise_per_rad = s.rotation_noise_per_m = 0;
  s.way_scale_sigma = s.heading_scale_sigma = s.heading_per_m_sigma = 0;
  s.side_per_m_sigma = 0;
  s.rejuvenate = false;
  s.smooth_map = false;
  s.detect_slips = false;
  s.measurement_inflation = 1;
  s.measurement_sigma = 0.03;  // its value is not given: a ToF camera of its time
  s.timing_sigma = 0;
  s.minimum_landmark_sigma = 0;
  s.rejection = RejectionWeight::constant;
  s.maximum_observations = std::numeric_limits<int>::max();
  s.guided = false;
  s.descriptor_ratio = 1;  // the nearest descriptor within descriptor_distance
  s.descriptor_blend = 0;
  s.use_bearings = false;
  s.verify_by_consensus = false;
  s.close_loops = false;
  s.maximum_new_landmarks = std::numeric_limits<int>::max();
  s.cell_capacity = std::numeric_limits<int>::max();
  s.remove_landmarks = false;
  s.minimum_observations = 1;
  return s;
}

void check(const FastSlamSettings& settings) {
  check<FastSlamSettings>(settings, "fastslam");
}

void FastSlamSettings::describe(SettingsVisitor& s) {
  constexpr double any = std::numeric_limits<int>::max();

  s.number("particles", particles, "", {1, 100000}, "hypotheses of the robot's path, each with its map");
  s.number("seed", seed, "", {0, any}, "of the draws");
  s.choice("proposal", proposal, proposal_names,
           "where particles are drawn from: odometry (FastSLAM 1.0), or that and the observations (2.0)");
  s.number("proposal_iterations", proposal_iterations, "", {1, 20}, "Gauss-Newton steps of the 2.0 proposal");
  s.number("huber_width", huber_width, "sigmas", {0.1, 1e6},
           "residuals beyond lose influence on the proposal");
  s.choice("resampling", resampling, resampling_names, "scheme by which particles survive");
  s.number("resample_fraction", resample_fraction, "", {0, 1},
           "resamples when the effective sample size is below this share of the particles; 1: every step");
  s.choice("estimate", estimate, estimate_names, "which pose is reported: the best particle's or their mean");
  s.section("mount_error", mount_error,
            "what the told covariance of a pose holds for the head's place on the robot");
  s.number(
      "draw_share", draw_share, "", {0, 1},
      "of the variance by which particles are drawn, what their mean errs by: weights choose among draws");
  s.number("free_draw_share", free_draw_share, "", {0, 1},
           "the same with six degrees of freedom, which as many particles fill more thinly");
  s.number("systematic_depth", systematic_depth, "", {0, 1},
           "part of a depth's stated sigma that is alike for all that lies at one range, always");
  s.number("view_share", view_share, "", {0, 1},
           "part of a measurement's other variance that stays while the feature is seen from the same side");
  s.number("view_step", view_step, "rad", {1e-3, 10},
           "by which the view must turn, or the distance change in ratio, for that part to be another one");
  s.number("focal_sigma", focal_sigma, "", {0, 0.1}, "of the calibrated focal lengths, ratio");
  s.number("stamp_sigma", stamp_sigma, "s", {0, 1}, "of the images' stamps, all alike");
  s.number("shutter_sigma", shutter_sigma, "s", {0, 1},
           "of the time from an image's first row to its last, where rows are not all of one moment");
  s.number("slide_sigma", slide_sigma, "", {0, 1},
           "of the ratio by which all landmarks slide along with the robot, blobs on edges do");
  s.number("bend_sigma", bend_sigma, "rad/m", {0, 1},
           "of the turn about the vertical by which all landmarks bend straight ways alike, as SURF's places "
           "lean");

  s.flag("use_motion_covariance", use_motion_covariance,
         "odometry's own covariance is used; false: the noise is translation_noise and the like alone");
  s.number("translation_noise", translation_noise, "m", {1e-6, 10}, "of a step, added in variance");
  s.number("rotation_noise", rotation_noise, "rad", {1e-6, 10}, "of a step, added in variance");
  s.number("translation_noise_per_m", translation_noise_per_m, "m per m", {0, 10},
           "noise of a step by the way driven");
  s.number("rotation_noise_per_rad", rotation_noise_per_rad, "rad per rad", {0, 10},
           "noise of a step by the angle turned");
  s.number("rotation_noise_per_m", rotation_noise_per_m, "rad per m", {0, 10},
           "noise of the heading by the way driven");
  s.section("ground", ground, "the plane that a robot on wheels is said to drive on");
  s.number("ground_rise_per_m", ground_rise_per_m, "m per m", {0, 10},
           "noise of the height by the way driven, once the floor was found not to be flat");
  s.number("ground_tilt_per_m", ground_tilt_per_m, "rad per m", {0, 10},
           "noise of roll and pitch by the way driven, once the floor was found not to be flat");
  s.number("visual_factor", visual_factor, "", {1, 1000},
           "on sigma of visual odometry, which was made from the same features");

  s.number("way_scale_sigma", way_scale_sigma, "", {0, 1},
           "systematic error of the way that wheels tell, ratio; it is learned while driving");
  s.number("heading_scale_sigma", heading_scale_sigma, "", {0, 1},
           "systematic error of the angle that wheels tell, ratio; learned");
  s.number("heading_per_m_sigma", heading_per_m_sigma, "rad per m", {0, 1},
           "systematic drift of the heading by the way driven; learned");
  s.number("side_per_m_sigma", side_per_m_sigma, "m per m", {0, 1},
           "systematic way aside by the way driven: the head looks aside of where the wheels roll; learned");
  s.number("calibration_walk", calibration_walk, "per root metre", {0, 10},
           "of the sigmas of way and heading: how fast these errors may change");

  s.number("range_offset_sigma", range_offset_sigma, "m", {0, 10},
           "what a range-bearing sensor's ranges may be off, all alike; learned with the smoothed path");
  s.number("range_scale_sigma", range_scale_sigma, "", {0, 1},
           "what a range-bearing sensor's ranges may be off, ratio; learned with the smoothed path");
  s.number("bearing_offset_sigma", bearing_offset_sigma, "rad", {0, 1},
           "what a range-bearing sensor's mount may be off; learned with the smoothed path");

  s.flag("detect_slips", detect_slips, "many observations may agree on a motion that odometry excludes");
  s.number("slip_gate", slip_gate, "", {0.1, 1e6},
           "squared Mahalanobis distance of that motion from the odometry's");

  s.number("minimum_range", minimum_range, "m", {0, 1000}, "nearest 3-D points that are used");
  s.number("maximum_range", maximum_range, "m", {0, 1000}, "farthest 3-D points that are used");
  s.require(minimum_range <= maximum_range, "maximum_range", "must not be below minimum_range");
  s.number("measurement_inflation", measurement_inflation, "", {0.01, 1e4},
           "factor on each measurement covariance: errors of one feature are correlated in time");
  s.number("measurement_sigma", measurement_sigma, "m", {0, 10},
           "on each axis, of every 3-D point alike (the thesis's R); 0: what the sensor's model says of it");
  s.number(
      "timing_sigma", timing_sigma, "s", {0, 1},
      "of the moment at which a camera saw a feature (exposure, rows, the depths' clock): its measurement "
      "is wider by what it moves in that time");
  s.number("correlation_time", correlation_time, "s", {0, 1e4},
           "over which a sensor's errors on one landmark stay alike (fall to 1/e); 0: independent");
  s.number("minimum_landmark_sigma", minimum_landmark_sigma, "m", {0, 10},
           "added in variance after an update: a landmark is never certain");
  s.number("maximum_observations", maximum_observations, "", {1, any},
           "used a step, spread over the image, best known first");

  s.number("gate", gate, "", {1e-12, 1},
           "an observation belongs to its landmark when exp(-d^2/2) is no less (thesis, 2.5)");
  s.choice("rejection", rejection, rejection_names,
           "what a rejected observation does to a weight: factor p0, or the landmark's density at the gate");
  s.number("p0", p0, "1/m^3", {1e-300, 1e9}, "density for the rejection `constant`");
  s.number("descriptor_ratio", descriptor_ratio, "", {1e-3, 1},
           "of the best and second best descriptor's distance; 1: the nearest counts");
  s.number("descriptor_distance", descriptor_distance, "", {1e-3, 2}, "largest distance of unit descriptors");
  s.number("same_place", same_place, "m", {0, 100}, "nearer landmarks are no rivals in the ratio test");
  s.number("search_radius", search_radius, "image widths", {0, 2},
           "around the predicted pixel, after a slip");
  s.flag("guided", guided,
         "landmarks are sought where they should be seen; false: by descriptor, in the whole map");
  s.flag("use_bearings", use_bearings, "features without depth measure known landmarks");
  s.number("visibility_margin", visibility_margin, "image widths", {0, 1},
           "beyond the border in which landmarks may still be seen");
  s.number("descriptor_blend", descriptor_blend, "", {0, 1},
           "of the newest descriptor in the landmark's; 0: the first one stays");
  s.flag("verify_by_consensus", verify_by_consensus, "drops matches that no common pose explains");
  s.require(guided || !verify_by_consensus, "guided", "needs verify_by_consensus: false where it is false");
  s.number("minimum_consensus", minimum_consensus, "", {3, 100000},
           "matches that must agree for a pose to be believed");
  s.flag("close_loops", close_loops, "by place recognition in the whole map");
  s.number("loop_steps", loop_steps, "", {1, 1e6},
           "in a row that must recognise a place before the pose jumps there");
  s.number("relocalise_after", relocalise_after, "", {1, 1e6},
           "steps without consensus after which the whole map is searched");
  s.number(
      "lost_after", lost_after, "s", {0, 3600},
      "of motion that no odometry knows, nothing being recognised: the robot may be anywhere in its map");

  s.flag("rejuvenate", rejuvenate,
         "with known landmarks in the plane: smooths the path where it pays and draws the particles anew");
  s.number("rejuvenation_share", rejuvenation_share, "", {1e-6, 1},
           "of a core's time for the solver; twice that at few lineages");
  s.number("rejuvenation_lineages", rejuvenation_lineages, "", {0, 1},
           "of the particles: distinct ancestors since they were drawn anew; fewer are few");
  s.number("reunion_steps", reunion_steps, "", {0, 1e9},
           "a landmark unseen for so many steps makes the path be smoothed when it is seen again");

  s.flag("smooth_map", smooth_map, "keeps keyframes of 3-D landmarks, so that path and map can be smoothed");
  s.flag("bend_closed_loops", bend_closed_loops, "smooths path and map unasked, too, when a loop was closed");

  s.number("maximum_new_landmarks", maximum_new_landmarks, "", {1, any}, "landmarks that a step may make");
  s.number("cell_capacity", cell_capacity, "", {1, any},
           "landmarks seen in one of 16 x 12 image cells before no more are made");
  s.flag("remove_landmarks", remove_landmarks, "landmarks that should be seen and are not go");
  s.number("odds_hit", odds_hit, "", {0, 100}, "log-odds that an observation adds to a landmark's existence");
  s.number("odds_miss", odds_miss, "", {-100, 0}, "log-odds that an observation that fails to come adds");
  s.number("odds_new", odds_new, "", {-1e6, 1e6}, "log-odds of a new landmark");
  s.number("odds_remove", odds_remove, "", {-1e6, 1e6}, "log-odds below which a landmark goes");
  s.number("odds_maximum", odds_maximum, "", {0, 1e6},
           "log-odds that a landmark's existence does not exceed");
  s.require(odds_remove <= odds_new && odds_new <= odds_maximum, "odds_new",
            "must lie between odds_remove and odds_maximum");
  s.number("minimum_observations", minimum_observations, "", {1, 100000},
           "of a landmark before it is given out");
  s.number("tentative_steps", tentative_steps, "", {1, 1e9},
           "a landmark not given out and not seen for so many steps is forgotten");
}

}  // namespace lcmslam
