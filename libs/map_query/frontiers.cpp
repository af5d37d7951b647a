#include <lcmslam/map_query/frontiers.hpp>

#include <algorithm>
#include <limits>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

using Cell = Eigen::Vector3i;

std::vector<Cell> frontier_cells(const OccupancyGrid& grid, const FrontierSettings& settings) {
  const auto low = static_cast<float>(settings.lowest), high = static_cast<float>(settings.highest);
  std::vector<Cell> found;
  BlockLogOdds cells;
  for (const Eigen::Vector3i& block : grid.blocks()) {
    grid.load(block, cells);
    for (int i = 0; i < block_cells; ++i) {
      if (state_of(cells[static_cast<std::size_t>(i)]) != CellState::free) continue;
      const Cell cell = cell_at(block, i);
      const float z = grid.centre_of(cell).z();
      if (z < low || z > high) continue;
      bool at_edge = false;
      for (int side = 0; side < 6 && !at_edge; ++side) {
        const Cell beside = cell + (side % 2 == 0 ? 1 : -1) * Cell::Unit(side / 2);
        const CellState state = block_of(beside) == block
                                    ? state_of(cells[static_cast<std::size_t>(place_in_block(beside))])
                                    : grid.state(beside);
        at_edge = state == CellState::unknown;
      }
      if (at_edge) found.push_back(cell);
    }
  }
  return found;
}

// The set that a cell belongs to; its cells are taken from the index' point of view.
std::vector<Cell> connected(const Cell& first, const VoxelIndex& index, std::vector<bool>& taken) {
  std::vector<Cell> set{first};
  for (std::size_t next = 0; next < set.size(); ++next)
    for (int i = 0; i < 27; ++i) {
      const Cell beside = set[next] + Cell(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      const std::int32_t found = index.find(voxel_key(beside));
      if (found == VoxelIndex::none || taken[static_cast<std::size_t>(found)]) continue;
      taken[static_cast<std::size_t>(found)] = true;
      set.push_back(beside);
    }
  return set;
}

Frontier describe(const std::vector<Cell>& set, const OccupancyGrid& grid) {
  Frontier frontier{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), set.size()};
  for (const Cell& cell : set) frontier.centroid += grid.centre_of(cell).cast<double>();
  frontier.centroid /= static_cast<double>(set.size());
  double nearest = std::numeric_limits<double>::infinity();
  for (const Cell& cell : set) {
    const Eigen::Vector3d centre = grid.centre_of(cell).cast<double>();
    const double distance = (centre - frontier.centroid).squaredNorm();
    if (distance >= nearest) continue;
    nearest = distance;
    frontier.cell = centre;
  }
  return frontier;
}

}  // namespace

std::vector<Frontier> find_frontiers(const OccupancyGrid& grid, const FrontierSettings& settings) {
  check(settings, "frontiers");
  const std::vector<Cell> cells = frontier_cells(grid, settings);
  VoxelIndex index(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i)
    index.insert(voxel_key(cells[i]), static_cast<std::int32_t>(i));
  std::vector<bool> taken(cells.size(), false);
  std::vector<Frontier> frontiers;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (taken[i]) continue;
    taken[i] = true;
    const std::vector<Cell> set = connected(cells[i], index, taken);
    if (set.size() >= static_cast<std::size_t>(settings.min_cells)) frontiers.push_back(describe(set, grid));
  }
  std::stable_sort(frontiers.begin(), frontiers.end(),
                   [](const Frontier& a, const Frontier& b) { return a.cells > b.cells; });
  return frontiers;
}

}  // namespace lcmslam
