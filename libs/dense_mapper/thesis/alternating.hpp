#pragma once
// The thesis's proposed ICP (algorithm 3.2, steps 5-10), for clouds whose relative pose nobody knows: turns
// between iterations on the overlapping part of the cloud and iterations on the SURF points. The cloud alone
// slides into a wrong basin, the few SURF points alone stay coarse; by turns each leads the other on.
//
//   1  colour_overlap, overlapping_points   S_sub
//   2  SURF correspondences                 S_SURF, T_SURF
//   3,4  align_start                        M_initial
//   5-10 register_alternating

#include <optional>

#include <lcmslam/dense_mapper/thesis/feature_pairs.hpp>
#include <lcmslam/registration/registration.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

enum class FeaturePairing {
  nearest,  ///< each iteration pairs a SURF point with the nearest one, as algorithm 3.2 is printed
  fixed     ///< as the descriptors paired them
};

inline constexpr Choice<FeaturePairing> pairing_names[] = {{"nearest", FeaturePairing::nearest},
                                                           {"fixed", FeaturePairing::fixed}};

struct AlternatingSettings {
  AlternatingSettings();

  RegistrationSettings registration;
  int cloud_iterations = 1;
  int feature_iterations = 1;
  FeaturePairing pairing = FeaturePairing::nearest;
  int max_rounds = 100;
  double epsilon_rms = 1e-5;

  void describe(SettingsVisitor& s) {
    s.section("registration", registration,
              "one iteration of every variant of the thesis: point to point, all points");
    s.number("cloud_iterations", cloud_iterations, "", {0, 1000},
             "of a round, on the overlapping part of the cloud; 0: the SURF subset alone (figure 3.9)");
    s.number("feature_iterations", feature_iterations, "", {0, 1000},
             "of a round, on the SURF points; 0: the overlapping part of the cloud alone");
    s.require(cloud_iterations + feature_iterations > 0, "feature_iterations",
              "must not be 0 where cloud_iterations is");
    s.choice("pairing", pairing, pairing_names,
             "SURF points pair with the nearest one (algorithm 3.2 as printed) or as their descriptors do");
    s.number("max_rounds", max_rounds, "", {1, 10000},
             "rounds of iterations on the cloud and on the SURF points");
    s.number("epsilon_rms", epsilon_rms, "m", {0, 1000},
             "stops when the smaller error changes less in a round");
  }
};

struct AlternatingResult {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();  ///< that of the smaller error
  bool from_features = false;                                         ///< whose error is the smaller one
  std::vector<double> cloud_rms;  ///< m, point to point, after each round; NaN where nothing paired
  std::vector<double> feature_rms;
  StopReason stop = StopReason::too_few_pairs;
  bool ok() const { return stop == StopReason::converged || stop == StopReason::max_iterations; }
};

/// M_initial: least squares over the pairs by the estimator of the settings, a linear one (small angles)
/// repeated until it stands still; nothing when they do not fix a transform.
std::optional<Eigen::Isometry3d> align_start(const FeaturePairs& features,
                                             const RegistrationSettings& settings);

/// Throws std::invalid_argument for settings out of range and for feature sets of different sizes. Where one
/// of the two sets is too small, the other one goes on alone.
AlternatingResult register_alternating(const Cloud& overlap, const Target& target,
                                       const FeaturePairs& features, const Eigen::Isometry3d& T_start,
                                       const AlternatingSettings& settings = {});

}  // namespace lcmslam
