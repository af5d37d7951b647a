#pragma once
// A detection threshold that follows the scene: a dim corridor still gives features, a bookshelf does not
// cost ten times their budget.

#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct AdaptiveThresholdSettings {
  double start = 100;  ///< determinant of the Hessian; no key of its own: SurfSettings::hessian_threshold
  double lowest = 10;
  double highest = 1000;
  int wanted = 1200;  ///< blobs above the threshold, from which the budget chooses; no key: follows from it

  void describe(SettingsVisitor& s) {
    s.number("lowest_threshold", lowest, "grey values^2", {1e-3, 1e6},
             "hessian_threshold follows the scene down to this one: below noise begins");
    s.number("highest_threshold", highest, "grey values^2", {1e-3, 1e6},
             "hessian_threshold follows the scene up to this one");
  }
};

/// Moves from frame to frame, within bounds. Depends on the frames before alone: the same recording gives
/// the same thresholds.
class AdaptiveThreshold {
 public:
  /// Throws std::invalid_argument unless 0 < lowest <= start <= highest and wanted > 0.
  explicit AdaptiveThreshold(const AdaptiveThresholdSettings& settings);

  double value() const { return value_; }

  /// `blobs` were above value() in the image just seen. Counts near `wanted` change nothing.
  void observe(int blobs);

  /// It can fall no further: where few blobs are found besides, the scene has little texture, or the image is
  /// blurred.
  bool at_lowest() const { return value_ <= settings_.lowest; }

 private:
  AdaptiveThresholdSettings settings_;
  double value_;
};

}  // namespace lcmslam
