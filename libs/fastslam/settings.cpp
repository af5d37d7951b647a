#include <lcmslam/fastslam/settings.hpp>

#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace lcmslam {
namespace {

void require(const char* name, double value, double low, double high) {
  if (std::isfinite(value) && value >= low && value <= high) return;
  std::ostringstream text;
  text << "FastSlamSettings." << name << " = " << value << ": must lie in [" << low << ", " << high << "]";
  throw std::invalid_argument(text.str());
}

}  // namespace

FastSlamSettings thesis_preset() {
  FastSlamSettings s;
  s.planar = true;
  s.proposal = ProposalKind::motion;
  s.resampling = ResamplingScheme::multinomial;
  s.resample_fraction = 1;
  s.estimate = PoseEstimate::best;
  s.use_motion_covariance = false;
  s.translation_noise = 0.05;  // sigma_r of figure 2.1; its heading's noise is not given
  s.rotation_noise = 0.01;
  s.translation_noise_per_m = s.rotation_noise_per_rad = s.rotation_noise_per_m = 0;
  s.way_scale_sigma = s.heading_scale_sigma = s.heading_per_m_sigma = 0;
  s.rejuvenate = false;
  s.smooth_map = false;
  s.detect_slips = false;
  s.measurement_inflation = 1;
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

void check(const FastSlamSettings& s) {
  require("particles", s.particles, 1, 100000);
  require("proposal_iterations", s.proposal_iterations, 1, 20);
  require("huber_width", s.huber_width, 0.1, 1e6);
  require("resample_fraction", s.resample_fraction, 0, 1e6);
  require("shared_translation_sigma", s.shared_translation_sigma, 0, 10);
  require("shared_rotation_sigma", s.shared_rotation_sigma, 0, 10);
  require("translation_noise", s.translation_noise, 1e-6, 10);
  require("rotation_noise", s.rotation_noise, 1e-6, 10);
  require("translation_noise_per_m", s.translation_noise_per_m, 0, 10);
  require("rotation_noise_per_rad", s.rotation_noise_per_rad, 0, 10);
  require("rotation_noise_per_m", s.rotation_noise_per_m, 0, 10);
  require("visual_factor", s.visual_factor, 1, 1e3);
  require("way_scale_sigma", s.way_scale_sigma, 0, 1);
  require("heading_scale_sigma", s.heading_scale_sigma, 0, 1);
  require("heading_per_m_sigma", s.heading_per_m_sigma, 0, 1);
  require("calibration_walk", s.calibration_walk, 0, 10);
  require("range_offset_sigma", s.range_offset_sigma, 0, 10);
  require("range_scale_sigma", s.range_scale_sigma, 0, 1);
  require("bearing_offset_sigma", s.bearing_offset_sigma, 0, 1);
  require("slip_gate", s.slip_gate, 0.1, 1e6);
  require("minimum_range", s.minimum_range, 0, 1e6);
  require("maximum_range", s.maximum_range, s.minimum_range, 1e6);
  require("measurement_inflation", s.measurement_inflation, 0.01, 1e4);
  require("correlation_time", s.correlation_time, 0, 1e4);
  require("minimum_landmark_sigma", s.minimum_landmark_sigma, 0, 10);
  require("maximum_observations", s.maximum_observations, 1, std::numeric_limits<int>::max());
  require("gate", s.gate, 1e-12, 1);
  require("p0", s.p0, 1e-300, 1e300);
  require("descriptor_ratio", s.descriptor_ratio, 0, 1);
  require("descriptor_distance", s.descriptor_distance, 0, 2);
  require("same_place", s.same_place, 0, 100);
  require("search_radius", s.search_radius, 0, 10);
  require("visibility_margin", s.visibility_margin, 0, 1);
  require("descriptor_blend", s.descriptor_blend, 0, 1);
  require("minimum_consensus", s.minimum_consensus, 3, 1e6);
  require("loop_steps", s.loop_steps, 1, 1e6);
  require("relocalise_after", s.relocalise_after, 1, 1e9);
  require("rejuvenation_share", s.rejuvenation_share, 1e-6, 1);
  require("rejuvenation_lineages", s.rejuvenation_lineages, 0, 1);
  require("reunion_steps", s.reunion_steps, 0, 1e9);
  require("maximum_new_landmarks", s.maximum_new_landmarks, 0, std::numeric_limits<int>::max());
  require("cell_capacity", s.cell_capacity, 1, std::numeric_limits<int>::max());
  require("odds_hit", s.odds_hit, 0, 100);
  require("odds_miss", s.odds_miss, -100, 0);
  require("odds_maximum", s.odds_maximum, 0, 1e6);
  require("odds_remove", s.odds_remove, -1e6, s.odds_new);
  require("odds_new", s.odds_new, s.odds_remove, s.odds_maximum);
  require("minimum_observations", s.minimum_observations, 1, 1e6);
  require("tentative_steps", s.tentative_steps, 1, 1e9);
  if (!s.guided && s.verify_by_consensus)
    throw std::invalid_argument("FastSlamSettings.guided = false: needs verify_by_consensus = false");
}

}  // namespace lcmslam
