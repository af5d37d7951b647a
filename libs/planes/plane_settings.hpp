#pragma once
// Settings of planes and of the objects that stand on them.

#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct FramePlaneSettings {
  int cells_across = 40;
  double least_valid = 0.6;
  double max_sigma = 0.03;
  double flatness = 1.4;
  double max_angle = 0.25;
  double max_distance_sigmas = 3;
  int min_cells = 6;

  void describe(SettingsVisitor& s) {
    s.number("cells_across", cells_across, "", {8, 160},
             "square cells, which may be plane, in the width of a depth image");
    s.number("least_valid", least_valid, "", {0.05, 1}, "share of a cell's pixels that must have depth");
    s.number("max_sigma", max_sigma, "m", {0.001, 10}, "of depth up to which pixels may be a plane's");
    s.number("flatness", flatness, "", {0.5, 100},
             "sigmas of depth that a cell's points may lie off its plane, root mean square");
    s.number("max_angle", max_angle, "rad", {0.01, 1.5}, "between a cell's normal and its plane's");
    s.number("max_distance_sigmas", max_distance_sigmas, "", {0.5, 100},
             "sigmas of depth that what belongs to a plane may lie off it");
    s.number("min_cells", min_cells, "", {2, 10000}, "that make a plane, cut in pieces or not");
  }
};

struct PlaneMapSettings {
  double max_angle = 0.09;
  double max_distance = 0.03;
  double grid = 0.02;
  double up_angle = 0.14;
  double min_area = 0.06;
  double table_height = 0.25;
  int min_looks = 2;
  double max_reach = 10;
  double memory = 64;

  void describe(SettingsVisitor& s) {
    s.number("max_angle", max_angle, "rad", {0.005, 1}, "between planes that are one");
    s.number("max_distance", max_distance, "m", {0.001, 1},
             "between planes that are one, besides what is uncertain");
    s.number("grid", grid, "m", {0.005, 1}, "of the cells that tell a plane's outline");
    s.number("up_angle", up_angle, "rad", {0.01, 0.7},
             "from upright or level that a wall, floor or table may be");
    s.number("min_area", min_area, "m^2", {1e-4, 1000}, "of a plane that gets a label");
    s.number("table_height", table_height, "m", {0.01, 10},
             "above the floor from which a level plane is a table top");
    s.number("min_looks", min_looks, "", {1, 255},
             "frames that must show a plane, and each part of its outline, before it counts");
    s.number("max_reach", max_reach, "m", {1, 1000},
             "from where a plane began to the middle of what a frame shows of it; what is farther is another "
             "plane: floors are not level over a whole building");
    s.number("memory", memory, "MB", {1, 100'000},
             "of all planes; beyond, those farthest from the camera go");
  }
};

struct ObjectSettings {
  double lift = 0.015;
  double height = 0.6;
  double cell = 0.02;
  int min_points = 40;

  void describe(SettingsVisitor& s) {
    s.number("lift", lift, "m", {0, 1}, "above the plane from which points are an object's");
    s.number("height", height, "m", {0.01, 10}, "above the plane up to which they are");
    s.number("cell", cell, "m", {0.002, 1}, "points in neighbouring cells of this size are of one object");
    s.number("min_points", min_points, "", {1, 1e6}, "of an object");
  }
};

}  // namespace lcmslam
