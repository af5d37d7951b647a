#pragma once
// Where free space meets unknown space: where an exploring robot would learn something (Yamauchi 1997).

#include <vector>

#include <lcmslam/map_layers/occupancy_grid.hpp>

namespace lcmslam {

struct FrontierSettings {
  int min_cells = 20;
  double lowest = -1000;
  double highest = 1000;

  void describe(SettingsVisitor& s) {
    s.number("min_cells", min_cells, "", {1, 1e9}, "of a frontier; smaller ones are gaps in what was seen");
    s.number("lowest", lowest, "m", {-1000, 1000}, "height in the map of what counts");
    s.number("highest", highest, "m", {-1000, 1000}, "height in the map of what counts");
    s.require(lowest < highest, "highest", "must be above lowest");
  }
};

struct Frontier {
  Eigen::Vector3d centroid;  ///< m
  Eigen::Vector3d cell;      ///< m, centre of the cell of the frontier that is nearest to the centroid
  std::size_t cells = 0;     ///< free ones with an unknown one beside them
};

/// Each a connected set (26 neighbours), the largest first. Throws std::invalid_argument that names a
/// setting.
std::vector<Frontier> find_frontiers(const OccupancyGrid& grid, const FrontierSettings& settings = {});

}  // namespace lcmslam
