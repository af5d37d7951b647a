#pragma once
// What real cameras do besides.

#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

/// All off: the pinned sensors.
struct CameraFaults {
  double rolling_shutter = 0;
  double exposure_adaptation = 0;
  double image_stamp_error = 0, depth_stamp_error = 0, stamp_jitter = 0;

  void describe(SettingsVisitor& s) {
    s.number("rolling_shutter", rolling_shutter, "s", {0, 0.1},
             "from the colour image's first row to its last, which no calibration tells; 0: the head's own");
    s.number("exposure_adaptation", exposure_adaptation, "s", {0, 60},
             "in which the exposure follows the light but for 1/e of the difference; 0: it stays");
    s.number("image_stamp_error", image_stamp_error, "s", {-1, 1},
             "of both images' stamps against the wheels' clock, which nobody tells");
    s.number("depth_stamp_error", depth_stamp_error, "s", {-1, 1},
             "of the depth image's stamp against colour's, which nobody tells");
    s.number("stamp_jitter", stamp_jitter, "s", {0, 0.1}, "of each image's stamp, at most, either way");
  }
};

/// Those of `own`, and where one is 0 that of `others`.
inline CameraFaults with_faults(CameraFaults own, const CameraFaults& others) {
  const auto take = [](double& mine, double theirs) { mine = mine != 0 ? mine : theirs; };
  take(own.rolling_shutter, others.rolling_shutter);
  take(own.exposure_adaptation, others.exposure_adaptation);
  take(own.image_stamp_error, others.image_stamp_error);
  take(own.depth_stamp_error, others.depth_stamp_error);
  take(own.stamp_jitter, others.stamp_jitter);
  return own;
}

}  // namespace lcmslam
