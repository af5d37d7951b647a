#pragma once
// Head, keyframes and landmarks that explain all pixels and depths at once.
//
// Every sighting gives two residuals in the colour image, and one in the depth image where the depth camera
// saw a smooth surface: the landmark must lie on it. Both are robust (Cauchy), their scales are what they are
// seen to be. What is measured of one thing again and again errs alike (a blob on a slanted wall, a step of
// disparity): all sigmas are taken `correlation` times as large.

#include <Eigen/Core>
#include <string>
#include <vector>

#include <lcmslam/calibration/self/head_parameters.hpp>
#include <lcmslam/calibration/self/scene_observations.hpp>

namespace lcmslam {

struct BundleSettings {
  int rounds = 16;
  int iterations = 8;
  double converged = 0.1;
  double pixel_gate = 12;
  double depth_gate = 0.15;
  double correlation = 3;
  double unobserved = 0.7;

  void describe(SettingsVisitor& s) {
    s.number("rounds", rounds, "", {1, 100},
             "of least squares at most; between them surfaces are looked up anew");
    s.number("iterations", iterations, "", {1, 1000}, "of least squares in a round");
    s.number("converged", converged, "", {0, 1},
             "of what no recording tells anyway: when nothing moves by more in a round, it ends");
    s.number("pixel_gate", pixel_gate, "pixels", {1, 1000}, "farther off at first is another landmark");
    s.number("depth_gate", depth_gate, "m", {0.01, 10}, "farther off at first is another surface");
    s.number("correlation", correlation, "", {1, 100}, "on sigmas: what is seen again errs as it did before");
    s.number("unobserved", unobserved, "", {0.01, 1},
             "of a prior's sigma that is left, above which the recording says nothing of a parameter");
  }
};

struct BundleResult {
  HeadNumbers priors{};        ///< standard deviations of the start; 0: held
  HeadNumbers sigmas{};        ///< what is left of them
  Eigen::MatrixXd covariance;  ///< head::count rows, 0 for what was held
  int rounds = 0;
  int pixels = 0, depths = 0;  ///< residuals that counted
  double pixel_scale = 0;      ///< pixels, of a blob of middle size
  double depth_scale = 0;      ///< of the calibration's depth noise
  /// Combinations of parameters of which the recording says nothing, in words.
  std::vector<std::string> unobserved_directions;

  bool held(head::Parameter p) const { return !(priors[p] > 0); }
};

/// Refines all three. Throws std::runtime_error when there is too little to compare.
BundleResult adjust_bundle(HeadModel& model, SceneObservations& scene, const CalibrationPriors& priors,
                           const BundleSettings& settings);

/// Whether the recording tells a parameter better than the start did.
inline bool is_observed(const BundleResult& result, head::Parameter p, const BundleSettings& settings) {
  return !result.held(p) && result.sigmas[p] < settings.unobserved * result.priors[p];
}

/// The head with what the recording does not tell as it was at the start, and one rolling shutter for both
/// images (rolling_shutter.hpp).
HeadModel observed_head(const HeadModel& model, const BundleResult& result, const BundleSettings& settings);

}  // namespace lcmslam
