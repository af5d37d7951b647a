#pragma once
// Registration of two frames whose relative pose is unknown or doubted: several starts are registered to the
// end, each together with the SURF pairs that it came from, and the clouds decide which of them is right.

#include <string>
#include <vector>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/registration/registration.hpp>

namespace lcmslam {

/// A start, and how much it is worth as knowledge (no information: as a start alone).
struct Hypothesis {
  Prior prior;  ///< of T_target_source
  std::string origin;
};

struct HypothesisSettings {
  int min_inliers = 6;              ///< of RANSAC: fewer than a tracker wants, because the clouds decide
  double ratios[2] = {0.8, 0.95};   ///< of the matching; the second one finds more and more wrong ones
  double floor_translation = 0.02;  ///< m, added (squared) to RANSAC's covariance: errors that features share
  double floor_rotation = 0.015;    ///< rad
  RegistrationSettings coarse, fine;
  double judged_distance = 0.06;  ///< m: pairs within it speak for a result
  HypothesisSettings();
};

struct HypothesisResult {
  RegistrationResult registration;  ///< of the best hypothesis; too_few_pairs when there is none
  std::string origin;
  double score = 0;  ///< 0..1, share of the source's points that lie on the target's surface
};

/// By the SURF features, in the frame of both colour cameras: none, one or two that differ.
std::vector<Hypothesis> surf_hypotheses(const FeatureFrame& source, const FeatureFrame& target,
                                        const HypothesisSettings& settings = {});

/// The hypothesis whose registration lies best on the target. Clouds in the frames of the hypotheses, with
/// normals; the first of equals wins.
HypothesisResult register_hypotheses(const Cloud& source, const Target& target,
                                     const std::vector<Hypothesis>& hypotheses,
                                     const HypothesisSettings& settings = {});

}  // namespace lcmslam
