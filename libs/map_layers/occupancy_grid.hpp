#pragma once
// What space is free, occupied or unknown: a hash of blocks of 8 x 8 x 8 cells with log-odds, packed as
// packed_cells.hpp says. A block whose cells all say the same, as most of the air does, is one byte.
//
// The grid stores; depth_carver.hpp writes into it. One thread at a time.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <lcmslam/map_layers/block_table.hpp>
#include <lcmslam/map_layers/occupancy_settings.hpp>
#include <lcmslam/map_layers/packed_cells.hpp>

namespace lcmslam {

enum class CellState : std::uint8_t { unknown, free, occupied };

inline CellState state_of(LogOdds value) {
  if (value == unknown_log_odds) return CellState::unknown;
  return value > 0 ? CellState::occupied : CellState::free;
}

/// What is occupied in a block now: for each z a bit for each 8 y + x.
struct OccupancyChange {
  Eigen::Vector3i block;
  std::array<std::uint64_t, block_side> occupied{};
};

class OccupancyGrid {
 public:
  /// Throws std::invalid_argument that names the setting.
  explicit OccupancyGrid(const OccupancySettings& settings);

  const OccupancySettings& settings() const { return settings_; }
  float cell_size() const { return cell_size_; }
  Eigen::Vector3i cell_of(const Eigen::Vector3f& point) const { return voxel_of(point, 1 / cell_size_); }
  Eigen::Vector3f centre_of(const Eigen::Vector3i& cell) const {
    return (cell.cast<float>().array() + 0.5f) * cell_size_;
  }

  CellState state(const Eigen::Vector3i& cell) const;
  /// Of a point in the map frame, m; unknown where it is not finite.
  CellState state(const Eigen::Vector3f& point) const;

  /// The block's cells, all unknown where there is none. For writers: load, change, store.
  void load(const Eigen::Vector3i& block, BlockLogOdds& cells) const;
  void store(const Eigen::Vector3i& block, const BlockLogOdds& cells);
  /// What all of the block's cells say; nothing when they differ.
  std::optional<LogOdds> uniform(const Eigen::Vector3i& block) const;
  void store_uniform(const Eigen::Vector3i& block, LogOdds value);

  /// When there are too many blocks those farthest from the point give way.
  void make_room(const Eigen::Vector3f& point);
  /// Blocks that gave way since the beginning.
  std::size_t forgotten() const { return forgotten_; }

  /// What became or ceased to be occupied since the last call, in the order of the first change. Blocks that
  /// are gone count as free.
  std::vector<OccupancyChange> take_changes();
  /// What it holds, for a thread of its own; without the changes that nobody took yet.
  OccupancyGrid copy() const;
  /// Becomes the other; all that either holds counts as changed.
  void adopt(OccupancyGrid other);

  /// Coordinates of all blocks, in the order in which they were made.
  std::vector<Eigen::Vector3i> blocks() const;
  std::size_t memory_bytes() const;

 private:
  void mark_changed(const Eigen::Vector3i& block);

  OccupancySettings settings_;
  float cell_size_;
  BlockTable<PackedCells> blocks_;
  VoxelIndex changed_index_;
  std::vector<Eigen::Vector3i> changed_;
  std::size_t forgotten_ = 0;
};

}  // namespace lcmslam
