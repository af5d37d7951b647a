#pragma once
// Cells in which a surface was seen, by blocks, each once.

#include <lcmslam/map_layers/occupancy_grid.hpp>

namespace lcmslam {

class HitCells {
 public:
  using Flags = std::array<std::uint8_t, block_cells>;  // 1: hit

  void clear();
  void add(const Eigen::Vector3i& cell);
  /// Those of a block; null where there is none.
  const Flags* find(const Eigen::Vector3i& block) const;

  /// Each cell is more likely occupied by one hit, see OccupancySettings.
  void hit(OccupancyGrid& grid) const;
  /// Each cell is occupied, as by one hit of an unknown one, however often it was seen through.
  void occupy(OccupancyGrid& grid) const;

  /// A bit a cell, blocks in the order in which they came.
  std::vector<OccupancyChange> bits() const;

 private:
  void raise(LogOdds least, OccupancyGrid& grid) const;
  struct Block {
    Eigen::Vector3i block;
    Flags hit{};
  };
  VoxelIndex index_;
  std::vector<Block> blocks_;
  std::size_t last_ = 0;  // that was added to
};

/// Visits each cell whose bit is set.
template <class Visit>
void for_each_cell(const std::vector<OccupancyChange>& bits, const Visit& visit) {
  for (const OccupancyChange& change : bits)
    for (int z = 0; z < block_side; ++z)
      for (std::uint64_t left = change.occupied[static_cast<std::size_t>(z)]; left != 0; left &= left - 1)
        visit(cell_at(change.block, 64 * z + __builtin_ctzll(left)));
}

/// One hit for each of them.
void hit(const std::vector<OccupancyChange>& bits, OccupancyGrid& grid);

}  // namespace lcmslam
