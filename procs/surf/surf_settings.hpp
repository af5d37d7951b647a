#pragma once
#include <lcmslam/planes/range_error.hpp>
#include <lcmslam/runtime/node_settings.hpp>
#include <lcmslam/surf/adaptive_threshold.hpp>
#include <lcmslam/surf/surf.hpp>

namespace lcmslam {

/// Section `surf`.
struct SurfNodeSettings {
  SurfSettings surf;
  AdaptiveThresholdSettings threshold;  ///< what has no key of its own follows from `surf`
  RangeErrorSettings range_error;
  double largest_depth_step = 0.05;
  double rate = 0;
  int frame_queue = 2;

  void describe(SettingsVisitor& s) {
    surf.describe(s);
    s.require(surf.hessian_threshold > 0, "hessian_threshold", "must be above 0");
    s.require(surf.budget.max_features >= 1 && surf.budget.max_features <= 5000, "max_features",
              "must be a whole number from 1 to 5000: one message holds no more features");
    threshold.describe(s);
    s.section("range_error", range_error, "what the depth camera errs by at each range, learned from planes");
    s.number("largest_depth_step", largest_depth_step, "", {0, 1000},
             "of the surface under a feature, ratio: a feature beside which depth leaves its plane by more "
             "lies on an "
             "edge, moves as the view does, and is left out");
    s.number("rate", rate, "Hz", {0, 1000}, "of the images that are used, at most; 0: every image");
    describe_frame_queue(s, frame_queue);
  }
};

}  // namespace lcmslam
