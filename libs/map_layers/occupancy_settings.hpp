#pragma once
// How space is remembered as free, occupied or unknown.

#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct OccupancySettings {
  double cell_size = 0.04;
  double max_range = 5;
  double hit = 0.7;
  double miss = 0.34;
  double most_occupied = 0.86;
  double most_free = 0.12;
  double depth_slack = 0.002;
  int max_blocks = 200'000;
  int max_keyframes = 2000;

  void describe(SettingsVisitor& s) {
    s.number("cell_size", cell_size, "m", {0.005, 1}, "side of a cell");
    s.number("max_range", max_range, "m", {0.1, 30}, "along the optical axis up to which depth is believed");
    s.number("hit", hit, "", {0.52, 0.99}, "probability that a cell is occupied in which depth is measured");
    s.number("miss", miss, "", {0.01, 0.48}, "probability that a cell is occupied that is seen through");
    s.number("most_occupied", most_occupied, "", {0.52, 0.99},
             "probability beyond which no further hit counts: what moved away must leave soon");
    s.number("most_free", most_free, "", {0.01, 0.48}, "probability below which no further miss counts");
    s.number(
        "depth_slack", depth_slack, "1/m", {0, 0.1},
        "a cell is seen through when the depth behind it is farther by more than this times the distance "
        "squared: noise of the sensor");
    s.number(
        "max_blocks", max_blocks, "", {100, 1e7},
        "of 8 x 8 x 8 cells that are kept (at most 0.7 kB each); a tenth, the farthest, gives way at a time");
    s.number(
        "max_keyframes", max_keyframes, "", {1, 1e5},
        "whose depth is kept for corrections of the graph (up to 90 kB each, 50 of 176x144, 40 of 640x480, "
        "and some 40 kB for what only frames saw beside them); "
        "those that the graph has given up make room first, then the oldest: what they alone saw goes with "
        "the next correction");
  }
};

}  // namespace lcmslam
