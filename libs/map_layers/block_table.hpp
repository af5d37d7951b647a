#pragma once
// The blocks of a sparse grid: 8 x 8 x 8 cells each, found by their coordinates.
//
// Blocks stand in the order in which they were made, which alone decides the order of a walk over them; the
// hash is only asked. What is erased leaves its place behind until as many places are empty as taken.

#include <Eigen/Core>
#include <utility>
#include <vector>

#include <lcmslam/cloud/voxel_index.hpp>

namespace lcmslam {

constexpr int block_side = 8;  // cells
constexpr int block_cells = block_side * block_side * block_side;

/// The block that a cell is in.
inline Eigen::Vector3i block_of(const Eigen::Vector3i& cell) {
  return {cell.x() >> 3, cell.y() >> 3, cell.z() >> 3};  // rounds down, below zero too
}

/// The cell's place in its block: x runs fastest, z slowest.
inline int place_in_block(const Eigen::Vector3i& cell) {
  return (cell.x() & 7) | (cell.y() & 7) << 3 | (cell.z() & 7) << 6;
}

/// The cell at a place of a block.
inline Eigen::Vector3i cell_at(const Eigen::Vector3i& block, int place) {
  return block_side * block + Eigen::Vector3i(place & 7, place >> 3 & 7, place >> 6);
}

template <class T>
class BlockTable {
 public:
  /// Null when there is none.
  const T* find(const Eigen::Vector3i& block) const {
    const std::int32_t slot = index_.find(voxel_key(block));
    return slot != VoxelIndex::none && taken_[static_cast<std::size_t>(slot)]
               ? &values_[static_cast<std::size_t>(slot)]
               : nullptr;
  }
  T* find(const Eigen::Vector3i& block) { return const_cast<T*>(std::as_const(*this).find(block)); }

  /// The block's value, T{} when it is new. Whoever holds others' addresses loses them.
  T& make(const Eigen::Vector3i& block) {
    const auto next = static_cast<std::int32_t>(values_.size());
    const auto slot = static_cast<std::size_t>(index_.insert(voxel_key(block), next));
    if (slot == values_.size()) {
      values_.emplace_back();
      blocks_.push_back(block);
      taken_.push_back(false);
    }
    if (!taken_[slot]) ++size_;
    taken_[slot] = true;
    return values_[slot];
  }

  void erase(const Eigen::Vector3i& block) {
    const std::int32_t found = index_.find(voxel_key(block));
    if (found == VoxelIndex::none || !taken_[static_cast<std::size_t>(found)]) return;
    values_[static_cast<std::size_t>(found)] = T{};
    taken_[static_cast<std::size_t>(found)] = false;
    --size_;
    if (values_.size() > 2 * size_ + 64) close_ranks();
  }

  std::size_t size() const { return size_; }

  /// Calls visit(block, value) for each, in the order in which they were made.
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (std::size_t i = 0; i < values_.size(); ++i)
      if (taken_[i]) visit(blocks_[i], values_[i]);
  }

  /// Of the table; what the values own besides is not known here.
  std::size_t memory_bytes() const {
    return index_.memory_bytes() + values_.capacity() * sizeof(T) +
           blocks_.capacity() * sizeof(Eigen::Vector3i) + taken_.capacity() / 8;
  }

 private:
  void close_ranks() {
    BlockTable closed;
    for (std::size_t i = 0; i < values_.size(); ++i)
      if (taken_[i]) closed.make(blocks_[i]) = std::move(values_[i]);
    *this = std::move(closed);
  }

  VoxelIndex index_;
  std::vector<T> values_;
  std::vector<Eigen::Vector3i> blocks_;
  std::vector<bool> taken_;
  std::size_t size_ = 0;
};

}  // namespace lcmslam
