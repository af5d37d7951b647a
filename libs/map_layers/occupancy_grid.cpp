#include <lcmslam/map_layers/occupancy_grid.hpp>

#include <algorithm>

#include <lcmslam/parallel/instruction_set.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

// Whether any cell became or ceased to be occupied.
LCMSLAM_VECTORISED(compare_occupied, (const LogOdds* a, const LogOdds* b, bool& differ), (a, b, differ)) {
  unsigned char any = 0;
  for (int i = 0; i < block_cells; ++i)
    any = static_cast<unsigned char>(any | static_cast<unsigned char>((a[i] > 0) != (b[i] > 0)));
  differ = any != 0;
}

}  // namespace

OccupancyGrid::OccupancyGrid(const OccupancySettings& settings)
    : settings_(settings), cell_size_(static_cast<float>(settings.cell_size)) {
  check(settings_, "occupancy");
}

CellState OccupancyGrid::state(const Eigen::Vector3i& cell) const {
  const PackedCells* block = blocks_.find(block_of(cell));
  return block == nullptr ? CellState::unknown : state_of(block->at(place_in_block(cell)));
}

CellState OccupancyGrid::state(const Eigen::Vector3f& point) const {
  return voxel_exists(point, 1 / cell_size_) ? state(cell_of(point)) : CellState::unknown;
}

void OccupancyGrid::load(const Eigen::Vector3i& block, BlockLogOdds& cells) const {
  const PackedCells* found = blocks_.find(block);
  if (found != nullptr)
    found->unpack(cells);
  else
    cells.fill(unknown_log_odds);
}

void OccupancyGrid::store(const Eigen::Vector3i& block, const BlockLogOdds& cells) {
  PackedCells& kept = blocks_.make(block);
  BlockLogOdds before;
  kept.unpack(before);
  if (before == cells) return;
  bool differ = false;
  compare_occupied(before.data(), cells.data(), differ);
  kept.pack(cells);
  if (differ) mark_changed(block);
}

std::optional<LogOdds> OccupancyGrid::uniform(const Eigen::Vector3i& block) const {
  const PackedCells* found = blocks_.find(block);
  if (found == nullptr) return unknown_log_odds;
  if (!found->uniform()) return std::nullopt;
  return found->value();
}

void OccupancyGrid::store_uniform(const Eigen::Vector3i& block, LogOdds value) {
  PackedCells& kept = blocks_.make(block);
  bool differ = (kept.value() > 0) != (value > 0);
  if (!kept.uniform()) {
    BlockLogOdds before, same;
    kept.unpack(before);
    same.fill(value);
    compare_occupied(before.data(), same.data(), differ);
  }
  kept.fill(value);
  if (differ) mark_changed(block);
}

void OccupancyGrid::make_room(const Eigen::Vector3f& point) {
  const auto most = static_cast<std::size_t>(settings_.max_blocks);
  if (blocks_.size() <= most) return;
  const Eigen::Vector3i here = block_of(cell_of(point));
  std::vector<Eigen::Vector3i> all = blocks();
  const std::size_t kept = most - most / 10;
  std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(kept), all.end(),
                   [&](const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
                     const auto far_a = (a - here).cast<std::int64_t>().squaredNorm();
                     const auto far_b = (b - here).cast<std::int64_t>().squaredNorm();
                     return far_a != far_b ? far_a < far_b : voxel_key(a) < voxel_key(b);
                   });
  for (std::size_t i = kept; i < all.size(); ++i) {
    blocks_.erase(all[i]);
    mark_changed(all[i]);
  }
  forgotten_ += all.size() - kept;
}

void OccupancyGrid::mark_changed(const Eigen::Vector3i& block) {
  const auto next = static_cast<std::int32_t>(changed_.size());
  if (changed_index_.insert(voxel_key(block), next) == next) changed_.push_back(block);
}

std::vector<OccupancyChange> OccupancyGrid::take_changes() {
  std::vector<OccupancyChange> changes;
  BlockLogOdds cells;
  for (const Eigen::Vector3i& block : changed_) {
    OccupancyChange change{block, {}};
    load(block, cells);
    for (std::size_t i = 0; i < cells.size(); ++i)
      if (cells[i] > 0) change.occupied[i / 64] |= std::uint64_t{1} << (i % 64);
    changes.push_back(change);
  }
  changed_.clear();
  changed_index_.clear();
  return changes;
}

OccupancyGrid OccupancyGrid::copy() const {
  OccupancyGrid other(settings_);
  blocks_.for_each([&](const Eigen::Vector3i& at, const PackedCells& block) {
    other.blocks_.make(at) = PackedCells(block);
  });
  return other;
}

void OccupancyGrid::adopt(OccupancyGrid other) {
  for (const Eigen::Vector3i& block : changed_) other.mark_changed(block);
  for (const Eigen::Vector3i& block : blocks()) other.mark_changed(block);
  for (const Eigen::Vector3i& block : other.blocks()) other.mark_changed(block);
  other.forgotten_ += forgotten_;
  *this = std::move(other);
}

std::vector<Eigen::Vector3i> OccupancyGrid::blocks() const {
  std::vector<Eigen::Vector3i> all;
  all.reserve(blocks_.size());
  blocks_.for_each([&](const Eigen::Vector3i& block, const PackedCells&) { all.push_back(block); });
  return all;
}

std::size_t OccupancyGrid::memory_bytes() const {
  std::size_t cells = 0;
  blocks_.for_each([&](const Eigen::Vector3i&, const PackedCells& block) {
    if (!block.uniform()) cells += block.size() + 16;  // 16: of the allocator
  });
  return blocks_.memory_bytes() + cells + changed_index_.memory_bytes() +
         changed_.capacity() * sizeof(Eigen::Vector3i);
}

}  // namespace lcmslam
