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

/// Where the first iteration of a registration starts.
enum class StartKind {
  by_variant,  ///< alternating: features; the others: prediction
  prediction,  ///< odometry's, or that of a velocity which goes on
  features,    ///< M_initial of algorithm 3.2; the prediction where SURF pairs do not fix one
  last_pose    ///< where the last frame was registered: no initial alignment (figures 3.8 to 3.11)
};
inline constexpr Choice<StartKind> start_names[] = {{"by_variant", StartKind::by_variant},
                                                    {"prediction", StartKind::prediction},
                                                    {"features", StartKind::features},
                                                    {"last_pose", StartKind::last_pose}};

struct ThesisSettings {
  AlternatingSettings icp;
  ColourOverlapSettings overlap;
  StartKind start = StartKind::by_variant;
  bool checked_features = true;
  double features_wait = 0.5;
  double features_within = 0.02;
  double merge_distance = 0.02;

  void describe(SettingsVisitor& s) {
    icp.describe(s);
    s.section("overlap", overlap, "of the variant alternating: which part of the cloud the last frame shows");
    s.choice(
        "start", start, start_names,
        "of the first iteration: odometry's prediction, the SURF pairs' M_initial, where the last frame "
        "was (no initial alignment), or what the variant takes: alternating features, others prediction");
    s.flag("checked_features", checked_features,
           "SURF correspondences pass RANSAC first; false: all, as in the thesis");
    s.number(
        "features_wait", features_wait, "s", {0, 60},
        "of message time that a frame waits for its features, where the variant or its start needs them; "
        "then it goes on without (STATUS: without_features)");
    s.number("features_within", features_within, "s", {0, 1},
             "between the colour image of the features and the depth image, where no odometry joins both: as "
             "of one moment, as in the thesis");
    s.number("merge_distance", merge_distance, "m", {0, 1000}, "nearer points of two clouds are one");
  }
};

}  // namespace lcmslam
