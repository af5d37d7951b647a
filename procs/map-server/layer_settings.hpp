#pragma once
#include <lcmslam/live_map/live_map_settings.hpp>

namespace lcmslam {

/// Section `map-server.layers`.
struct LayerSettings {
  bool make = true;
  double rate = 10;
  double surface_rate = 3;
  LiveMapSettings map;

  void describe(SettingsVisitor& s) {
    s.flag("make", make,
           "free space, distances, planes and the surface are derived from the camera's images");
    s.number("rate", rate, "1/s", {0, 1000},
             "frames besides keyframes that free and occupied space learns from");
    s.number("surface_rate", surface_rate, "1/s", {0, 1000},
             "frames besides keyframes by which the surface grows; not more than rate");
    map.describe(s);
  }
};

}  // namespace lcmslam
