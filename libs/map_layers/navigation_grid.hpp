#pragma once
// The map that a planner of wheeled robots wants: where the robot can stand, seen from above.
//
// The ground is followed from the robot outwards, column by column: a column's ground is the highest
// occupied cell that a step leads to. What is occupied above it, as high as the robot is, is in the way, also
// when it hangs. So a ramp is free, and a table is not. Where nothing is known the ground is believed to go
// on level for a while; those columns are unknown.

#include <opencv2/core.hpp>
#include <vector>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/map_layers/occupancy_grid.hpp>

namespace lcmslam {

struct NavigationSettings {
  double robot_height = 1.5;
  double robot_radius = 0.3;
  double max_step = 0.04;
  double max_slope = 0.17;
  double slope_length = 0.4;
  double max_gap = 1.5;
  double reach = 10;

  void describe(SettingsVisitor& s) {
    s.number("robot_height", robot_height, "m", {0.05, 5},
             "above the ground; what hangs lower is in the way");
    s.number("robot_radius", robot_radius, "m", {0, 5}, "around its position, where there must be ground");
    s.number("max_step", max_step, "m", {0, 1},
             "highest sill that the robot climbs; a cell of the occupancy grid at least");
    s.number("max_slope", max_slope, "rad", {0, 1.5}, "steepest ramp");
    s.number("slope_length", slope_length, "m", {0.05, 5}, "on which slopes are measured");
    s.number("max_gap", max_gap, "m", {0, 100}, "of unknown ground over which the ground is followed");
    s.number("reach", reach, "m", {0.5, 100}, "of the map to each side of the robot; files have all of it");
  }
};

struct NavigationGrid {
  static constexpr std::int8_t unknown = -1, free = 0, occupied = 100;  // as ROS writes them

  double cell_size = 0;             ///< m
  Eigen::Vector2d origin = {0, 0};  ///< m in the map, of the corner of least x and y
  cv::Mat_<std::int8_t> cells;      ///< row: y, column: x
  cv::Mat_<float> ground;           ///< m in the map, top of the ground; NaN where unknown

  /// Of the cell at the point (m in the map); unknown outside.
  std::int8_t at(double x, double y) const;
};

/// `T_map_robot`: the robot's base on the ground, z upwards, around which the grid lies. `also_stood` (m):
/// other places of its base, from which the ground is followed where it does not lead there from the robot:
/// through doors that have closed since. What lies outside the grid is left out. Throws std::invalid_argument
/// that names a setting or says that the pose is not finite.
NavigationGrid make_navigation_grid(const OccupancyGrid& grid, const NavigationSettings& settings,
                                    const Eigen::Isometry3d& T_map_robot,
                                    const std::vector<Eigen::Vector3d>& also_stood = {});

/// The same with a reach to all that the grid knows, 2500 cells at most: for files, which have the whole map.
NavigationSettings reaching_all(const OccupancyGrid& grid, NavigationSettings settings,
                                const Eigen::Isometry3d& T_map_robot);

}  // namespace lcmslam
