#pragma once
#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/runtime/node_settings.hpp>

namespace lcmslam {

/// Section `fastslam`. The preset gives the defaults of the filter's keys.
struct FastSlamNodeSettings {
  std::string preset = "modern";
  FastSlamSettings filter;
  std::string pose = "auto";
  std::string map_frame = "map";
  int frame_queue = 3;
  double max_wait = 0.15;
  double new_map_after = 30;
  double new_map_when_carried = 5;

  void describe_preset(SettingsVisitor& s) {
    s.choice("preset", preset, {"modern", "thesis"},
             "defaults of the other keys: the best we know, or the filter as the thesis describes it");
  }
  void describe(SettingsVisitor& s) {
    describe_preset(s);
    filter.describe(s);
    describe_pose(s, pose);
    describe_map_frame(s, map_frame);
    describe_frame_queue(s, frame_queue);
    describe_max_wait(s, max_wait);
    s.number(
        "new_map_after", new_map_after, "s", {0, 1e6},
        "of features of which none is known, since odometry was lost and the robot may be anywhere; then "
        "a new map begins beside the old one; 0: never");
    s.number(
        "new_map_when_carried", new_map_when_carried, "s", {0, 1e6},
        "of features that contradict the landmarks that should be there and are found nowhere else; then a "
        "new map begins beside the old one; 0: never");
  }
};

}  // namespace lcmslam
