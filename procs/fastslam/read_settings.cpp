#include "procs/fastslam/read_settings.hpp"

#include <lcmslam/configuration/named_choice.hpp>

namespace lcmslam {
FastSlamSettings read_fastslam_settings(const ConfigNode& c) {
  const std::string preset = c.choice("preset", "modern", {"modern", "thesis"});
  FastSlamSettings s = preset == "thesis" ? thesis_preset() : FastSlamSettings{};
  s.particles = c.get("particles", s.particles, Range{1, 100000});
  s.seed = static_cast<std::uint64_t>(c.get("seed", static_cast<int>(s.seed), Range{0, 2147483647}));
  s.proposal = named_choice<ProposalKind>(
      c, "proposal", s.proposal,
      {{"motion", ProposalKind::motion}, {"measurement", ProposalKind::measurement}});
  s.proposal_iterations = c.get("proposal_iterations", s.proposal_iterations, Range{1, 100});
  s.huber_width = c.get("huber_width", s.huber_width, Range{0.1, 1e6});
  s.resampling = named_choice<ResamplingScheme>(c, "resampling", s.resampling,
                                                {{"multinomial", ResamplingScheme::multinomial},
                                                 {"systematic", ResamplingScheme::systematic},
                                                 {"stratified", ResamplingScheme::stratified},
                                                 {"residual", ResamplingScheme::residual}});
  s.resample_fraction = c.get("resample_fraction", s.resample_fraction, Range{0, 1});
  s.estimate = named_choice<PoseEstimate>(c, "estimate", s.estimate,
                                          {{"best", PoseEstimate::best}, {"mean", PoseEstimate::mean}});
  s.use_motion_covariance = c.get("use_motion_covariance", s.use_motion_covariance);
  s.shared_translation_sigma = c.get("shared_translation_sigma", s.shared_translation_sigma, Range{0, 10});
  s.shared_rotation_sigma = c.get("shared_rotation_sigma", s.shared_rotation_sigma, Range{0, 10});
  const Range noise{0, 100};
  s.translation_noise = c.get("translation_noise", s.translation_noise, noise);
  s.rotation_noise = c.get("rotation_noise", s.rotation_noise, noise);
  s.translation_noise_per_m = c.get("translation_noise_per_m", s.translation_noise_per_m, noise);
  s.rotation_noise_per_rad = c.get("rotation_noise_per_rad", s.rotation_noise_per_rad, noise);
  s.rotation_noise_per_m = c.get("rotation_noise_per_m", s.rotation_noise_per_m, noise);
  s.visual_factor = c.get("visual_factor", s.visual_factor, Range{1, 1e6});
  s.way_scale_sigma = c.get("way_scale_sigma", s.way_scale_sigma, Range{0, 1});
  s.heading_scale_sigma = c.get("heading_scale_sigma", s.heading_scale_sigma, Range{0, 1});
  s.heading_per_m_sigma = c.get("heading_per_m_sigma", s.heading_per_m_sigma, Range{0, 1});
  s.calibration_walk = c.get("calibration_walk", s.calibration_walk, Range{0, 10});
  s.range_offset_sigma = c.get("range_offset_sigma", s.range_offset_sigma, Range{0, 10});
  s.range_scale_sigma = c.get("range_scale_sigma", s.range_scale_sigma, Range{0, 1});
  s.bearing_offset_sigma = c.get("bearing_offset_sigma", s.bearing_offset_sigma, Range{0, 1});
  s.rejuvenate = c.get("rejuvenate", s.rejuvenate);
  s.smooth_map = c.get("smooth_map", s.smooth_map);
  s.bend_closed_loops = c.get("bend_closed_loops", s.bend_closed_loops);
  s.rejuvenation_share = c.get("rejuvenation_share", s.rejuvenation_share, Range{1e-6, 1});
  s.rejuvenation_lineages = c.get("rejuvenation_lineages", s.rejuvenation_lineages, Range{0, 1});
  s.reunion_steps = c.get("reunion_steps", s.reunion_steps, Range{0, 1000000000});
  s.detect_slips = c.get("detect_slips", s.detect_slips);
  s.slip_gate = c.get("slip_gate", s.slip_gate, Range{0, 1e9});
  s.minimum_range = c.get("minimum_range", s.minimum_range, Range{0, 1000});
  s.maximum_range = c.get("maximum_range", s.maximum_range, Range{0, 1000});
  s.measurement_inflation = c.get("measurement_inflation", s.measurement_inflation, Range{1e-3, 1e6});
  s.correlation_time = c.get("correlation_time", s.correlation_time, Range{0, 1e4});
  s.maximum_observations = c.get("maximum_observations", s.maximum_observations, Range{1, 100000});
  s.minimum_landmark_sigma = c.get("minimum_landmark_sigma", s.minimum_landmark_sigma, Range{0, 10});
  s.gate = c.get("gate", s.gate, Range{0, 1});
  s.rejection = named_choice<RejectionWeight>(
      c, "rejection", s.rejection,
      {{"constant", RejectionWeight::constant}, {"floored", RejectionWeight::floored}});
  s.p0 = c.get("p0", s.p0, Range{0, 1e9});
  s.descriptor_ratio = c.get("descriptor_ratio", s.descriptor_ratio, Range{0, 1});
  s.descriptor_distance = c.get("descriptor_distance", s.descriptor_distance, Range{0, 2});
  s.same_place = c.get("same_place", s.same_place, Range{0, 100});
  s.search_radius = c.get("search_radius", s.search_radius, Range{0, 2});
  s.guided = c.get("guided", s.guided);
  s.use_bearings = c.get("use_bearings", s.use_bearings);
  s.visibility_margin = c.get("visibility_margin", s.visibility_margin, Range{0, 1});
  s.descriptor_blend = c.get("descriptor_blend", s.descriptor_blend, Range{0, 1});
  s.verify_by_consensus = c.get("verify_by_consensus", s.verify_by_consensus);
  s.minimum_consensus = c.get("minimum_consensus", s.minimum_consensus, Range{3, 100000});
  s.close_loops = c.get("close_loops", s.close_loops);
  s.loop_steps = c.get("loop_steps", s.loop_steps, Range{1, 1000000});
  s.relocalise_after = c.get("relocalise_after", s.relocalise_after, Range{1, 1000000});
  s.maximum_new_landmarks = c.get("maximum_new_landmarks", s.maximum_new_landmarks, Range{1, 100000});
  s.cell_capacity = c.get("cell_capacity", s.cell_capacity, Range{1, 1000000});
  s.remove_landmarks = c.get("remove_landmarks", s.remove_landmarks);
  s.odds_hit = c.get("odds_hit", s.odds_hit, Range{0, 100});
  s.odds_miss = c.get("odds_miss", s.odds_miss, Range{-100, 0});
  s.odds_new = c.get("odds_new", s.odds_new, Range{-1e6, 1e6});
  s.odds_remove = c.get("odds_remove", s.odds_remove, Range{-1e6, 1e6});
  s.odds_maximum = c.get("odds_maximum", s.odds_maximum, Range{0, 1e6});
  s.minimum_observations = c.get("minimum_observations", s.minimum_observations, Range{1, 100000});
  s.tentative_steps = c.get("tentative_steps", s.tentative_steps, Range{1, 1000000000});
  try {
    check(s);
  } catch (const std::invalid_argument& error) {
    c.fail("", error.what());
  }
  return s;
}

}  // namespace lcmslam
