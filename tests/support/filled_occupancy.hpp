#pragma once
// Occupancy grids that are filled by hand.

#include <Eigen/Geometry>

#include <lcmslam/map_layers/occupancy_grid.hpp>

namespace lcmslam {

/// Sets every cell whose centre lies in the box (m).
inline void fill(OccupancyGrid& grid, const Eigen::AlignedBox3f& box, LogOdds value) {
  const Eigen::Vector3i first = grid.cell_of(box.min()), last = grid.cell_of(box.max());
  BlockLogOdds cells;
  for (int z = first.z(); z <= last.z(); ++z)
    for (int y = first.y(); y <= last.y(); ++y)
      for (int x = first.x(); x <= last.x(); ++x) {
        const Eigen::Vector3i cell(x, y, z);
        if (!box.contains(grid.centre_of(cell))) continue;
        grid.load(block_of(cell), cells);
        cells[static_cast<std::size_t>(place_in_block(cell))] = value;
        grid.store(block_of(cell), cells);
      }
}

}  // namespace lcmslam
