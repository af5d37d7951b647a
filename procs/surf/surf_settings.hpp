#pragma once
#include <lcmslam/planes/range_error.hpp>
#include <lcmslam/rgbd/feature_support.hpp>
#include <lcmslam/runtime/node_settings.hpp>
#include <lcmslam/surf/adaptive_threshold.hpp>
#include <lcmslam/surf/surf.hpp>

namespace lcmslam {

/// Section `surf`.
struct SurfNodeSettings {
  SurfSettings surf;
  AdaptiveThresholdSettings threshold;  ///< what has no key of its own follows from `surf`
  RangeErrorSettings range_error;
  FeatureSupportSettings support;
  bool drop_folded = true;
  double rate = 0;
  int frame_queue = 2;

  void describe(SettingsVisitor& s) {
    surf.describe(s);
    s.require(surf.hessian_threshold > 0, "hessian_threshold", "must be above 0");
    s.require(surf.budget.max_features >= 1 && surf.budget.max_features <= 5000, "max_features",
              "must be a whole number from 1 to 5000: one message holds no more features");
    threshold.describe(s);
    s.section("range_error", range_error, "what the depth camera errs by at each range, learned from planes");
    support.describe(s);
    s.flag(
        "drop_folded", drop_folded,
        "features lose a time-of-flight depth that may lie a turn of its phase (depth_max) farther, by its "
        "amplitude; false: the camera measures with several frequencies and does not fold");
    s.number("rate", rate, "Hz", {0, 1000}, "of the images that are used, at most; 0: every image");
    describe_frame_queue(s, frame_queue);
  }
};

}  // namespace lcmslam
