#pragma once
// How well features are found again and matched on a recording, for ours and for those that one would
// use instead. Pairs of images some frames apart are judged with depth and a relative pose.
//
// A recording's measured poses are some pixels off. So each pair is judged with a pose from the images
// themselves: PnP-RANSAC on the matches of all families but the one judged, which thus cannot vouch for
// itself. Where one of these poses is not found or contradicts the recording's, the pair is left out for
// every method, and counted.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include <lcmslam/datasets/dataset.hpp>
#include "tools/study/feature_evaluation.hpp"
#include "tools/study/feature_methods.hpp"
#include "tools/study/score_comparison.hpp"

namespace lcmslam {

struct FeatureStudySettings {
  std::vector<int> apart = {5, 15, 30};  ///< frames between the two images of a pair, ascending
  int starts = 60;                       ///< first images, spread evenly over the recording
  int keypoints = 1000;                  ///< at most, by response
  double ratio = 0.8;                    ///< of matching
  EvaluationTolerances tolerances;
  ReferencePoseSettings pose;

  void check() const;  ///< throws std::invalid_argument naming the wrong value
};

/// A line of the result: a method's features, perhaps only as many as another method returned.
struct StudyRow {
  std::string name;
  std::size_t method = 0;                 ///< index
  std::optional<std::size_t> as_many_as;  ///< index of a method; keypoints with depth, in each image
};

struct DistanceScore {
  int pairs = 0;         ///< over which the others are means
  double keypoints = 0;  ///< with depth, an image
  double repeatability = 0, precision = 0, correct = 0;
};

struct MethodResult {
  StudyRow row;
  std::vector<DistanceScore> scores;  ///< by distance
  /// By distance, with dlib's SURF as the peer; empty for itself and where dlib is not there.
  std::vector<ScoreComparison> against_dlib;
  double milliseconds = 0;  ///< median of detect and describe, processor time of one thread; NaN where a row
                            ///< has no run of its own
};

struct FeatureStudyResult {
  std::vector<int> apart;
  std::vector<int> left_out;  ///< pairs without a pose to judge by, by distance
  int unreadable = 0;         ///< pairs with an image missing or without a measured pose
  std::vector<MethodResult> methods;
};

/// The methods' own rows and, where dlib is among them, ours with as many keypoints as dlib returned.
std::vector<StudyRow> study_rows(const FeatureMethods& methods);

/// First images: `count` indices, evenly spread, each with `reach` images behind it.
/// Throws std::invalid_argument when the recording is too short.
std::vector<std::size_t> spread_starts(std::size_t size, int reach, int count);

/// Without lens distortion; depth is looked up at the nearest pixel. Throws std::invalid_argument where
/// depth is not registered to colour.
StudyView study_view(const RgbdFrame& frame, const RgbdCalibration& calibration);

/// Throws std::invalid_argument when the recording has no true poses. One thread, and the same result
/// but for the times on every run.
FeatureStudyResult study_features(RgbdSource& source, FeatureMethods& methods,
                                  const FeatureStudySettings& settings);

/// The methods, and below how ours and the others differ from dlib's SURF, with 95 % intervals.
std::string feature_table(const FeatureStudyResult& result);
/// method,apart,pairs,left_out,keypoints,repeatability,precision,correct,milliseconds, then what
/// differs from dlib's SURF with the ends of the interval.
std::string feature_csv(const FeatureStudyResult& result);
nlohmann::json feature_json(const FeatureStudyResult& result, const FeatureStudySettings& settings);

}  // namespace lcmslam
