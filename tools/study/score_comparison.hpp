#pragma once
// Whether one method's scores differ from another's by more than the choice of pairs explains: a paired
// bootstrap (Efron & Tibshirani 1993) of blocks, because neighbouring starts share images (Künsch 1989).

#include <optional>
#include <vector>

#include "tools/study/feature_evaluation.hpp"

namespace lcmslam {

/// A number, and where 95 % of its resamples lie. NaN without a pair.
struct Interval {
  double value, low, high;
};

struct ScoreComparison {
  Interval repeatability;  ///< mean of the method's minus mean of the peer's
  Interval precision;      ///< likewise
  Interval correct;        ///< the method's correct matches over the peer's
};

struct BootstrapSettings {
  int resamples = 2000;
  int block = 1;  ///< starts that are drawn together; as many as one pair reaches over
};

/// Scores by start, both of the same pairs; nothing where a pair was left out. The same on every run.
/// Throws std::invalid_argument when the two do not belong together or a setting is below 1.
ScoreComparison compare_scores(const std::vector<std::optional<FeatureScore>>& method,
                               const std::vector<std::optional<FeatureScore>>& peer,
                               const BootstrapSettings& settings);

}  // namespace lcmslam
