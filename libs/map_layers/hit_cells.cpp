#include <lcmslam/map_layers/hit_cells.hpp>

#include <algorithm>

namespace lcmslam {

void HitCells::clear() {
  index_.clear();
  blocks_.clear();
}

void HitCells::add(const Eigen::Vector3i& cell) {
  const Eigen::Vector3i block = block_of(cell);
  if (blocks_.empty() || blocks_[last_].block != block) {
    const auto next = static_cast<std::int32_t>(blocks_.size());
    last_ = static_cast<std::size_t>(index_.insert(voxel_key(block), next));
    if (last_ == blocks_.size()) blocks_.push_back({block, {}});
  }
  blocks_[last_].hit[static_cast<std::size_t>(place_in_block(cell))] = 1;
}

const HitCells::Flags* HitCells::find(const Eigen::Vector3i& block) const {
  const std::int32_t slot = index_.find(voxel_key(block));
  return slot == VoxelIndex::none ? nullptr : &blocks_[static_cast<std::size_t>(slot)].hit;
}

void HitCells::hit(OccupancyGrid& grid) const {
  raise(log_odds(grid.settings().most_free), grid);
}

void HitCells::occupy(OccupancyGrid& grid) const {
  raise(0, grid);
}

/// From `least` at least.
void HitCells::raise(LogOdds least, OccupancyGrid& grid) const {
  const LogOdds step = log_odds(grid.settings().hit), most = log_odds(grid.settings().most_occupied);
  BlockLogOdds cells;
  for (const Block& seen : blocks_) {
    grid.load(seen.block, cells);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (seen.hit[i] == 0) continue;
      const int before = cells[i] == unknown_log_odds ? 0 : std::max(cells[i], least);
      cells[i] = static_cast<LogOdds>(std::min<int>(before + step, most));
    }
    grid.store(seen.block, cells);
  }
}

std::vector<OccupancyChange> HitCells::bits() const {
  std::vector<OccupancyChange> all;
  for (const Block& seen : blocks_) {
    OccupancyChange change{seen.block, {}};
    for (std::size_t i = 0; i < seen.hit.size(); ++i)
      if (seen.hit[i] != 0) change.occupied[i / 64] |= std::uint64_t{1} << (i % 64);
    all.push_back(change);
  }
  return all;
}

void hit(const std::vector<OccupancyChange>& bits, OccupancyGrid& grid) {
  HitCells cells;
  for_each_cell(bits, [&](const Eigen::Vector3i& cell) { cells.add(cell); });
  cells.hit(grid);
}

}  // namespace lcmslam
