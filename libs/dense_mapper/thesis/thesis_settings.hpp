#pragma once
// Which registration places the frames, and the settings of the thesis's.

#include <string>

#include <lcmslam/dense_mapper/thesis/alternating.hpp>
#include <lcmslam/rgbd/colour_overlap.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

enum class VariantKind {
  modern,       ///< the mapper's own
  plain,        ///< 3.1 from the prediction
  alternating,  ///< 3.2 from the SURF correspondences with the last frame; from the prediction where there
                ///< are none
  frustum       ///< 3.1 from the prediction, with the points that the last frame's sensor could see
};
inline constexpr Choice<VariantKind> variant_names[] = {{"modern", VariantKind::modern},
                                                        {"plain", VariantKind::plain},
                                                        {"alternating", VariantKind::alternating},
                                                        {"frustum", VariantKind::frustum}};
inline std::string to_string(VariantKind kind) {
  return name_of(kind, variant_names);
}

struct ThesisSettings {
  AlternatingSettings icp;
  ColourOverlapSettings overlap;
  bool checked_features = true;
  double merge_distance = 0.02;

  void describe(SettingsVisitor& s) {
    icp.describe(s);
    s.section("overlap", overlap, "of the variant alternating: which part of the cloud the last frame shows");
    s.flag("checked_features", checked_features,
           "SURF correspondences pass RANSAC first; false: all, as in the thesis");
    s.number("merge_distance", merge_distance, "m", {0, 1000}, "nearer points of two clouds are one");
  }
};

}  // namespace lcmslam
