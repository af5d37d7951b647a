#pragma once
// A signed distance field in blocks of 8 x 8 x 8 voxels, only where surfaces were measured.
//
// Voxel (i, j, k) stands at the point voxel_size * (i, j, k). Blocks are found by their coordinate and walked
// in the order in which they were made, so that nothing depends on the table's layout.

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include <lcmslam/cloud/voxel_index.hpp>

namespace lcmslam {

/// Eight bytes a voxel. The weight has 16 bits so that a look can be taken out as exactly as it was put in.
struct VoxelBlock {
  static constexpr int side = 8, voxels = side * side * side;
  static constexpr float full_look = 64;         ///< weight of the best look there is
  static constexpr float full_distance = 32767;  ///< what the truncation distance is kept as
  static constexpr int most_colour_weight = 160;

  std::int16_t distance[voxels] = {};  ///< from the surface, positive in free space
  std::uint16_t weight[voxels] = {};   ///< 0: nobody looked
  std::uint8_t blue[voxels] = {}, green[voxels] = {}, red[voxels] = {};
  std::uint8_t colour_weight[voxels] = {};  ///< 0: no colour is known

  static int index(int x, int y, int z) { return x + side * (y + side * z); }
};

class VoxelBlocks {
 public:
  struct Entry {
    Eigen::Vector3i at;        ///< coordinate of the block; its first voxel is side * at
    std::int64_t born = 0;     ///< number of the fusion that made it
    std::int64_t changed = 0;  ///< number of the fusion that changed it last
    std::unique_ptr<VoxelBlock> block;
  };
  static constexpr std::int32_t none = VoxelIndex::none;

  VoxelBlocks(double voxel_size, double truncation_voxels)
      : voxel_size_(static_cast<float>(voxel_size)),
        truncation_(static_cast<float>(voxel_size * truncation_voxels)) {}

  float voxel_size() const { return voxel_size_; }                     ///< m
  float truncation() const { return truncation_; }                     ///< m
  float block_size() const { return VoxelBlock::side * voxel_size_; }  ///< m
  std::size_t size() const { return entries_.size(); }
  Entry& operator[](std::size_t i) { return entries_[i]; }
  const Entry& operator[](std::size_t i) const { return entries_[i]; }
  const std::vector<Entry>& entries() const { return entries_; }

  /// The block that voxels around a point belong to.
  Eigen::Vector3i block_of(const Eigen::Vector3f& point) const {
    return voxel_of(point + Eigen::Vector3f::Constant(0.5f * voxel_size_), 1 / block_size());
  }
  /// Where a block's voxels end on average, m.
  Eigen::Vector3f centre(const Entry& entry) const {
    return (entry.at.cast<float>() * VoxelBlock::side + Eigen::Vector3f::Constant(3.5f)) * voxel_size_;
  }
  std::int32_t find(const Eigen::Vector3i& at) const { return index_.find(voxel_key(at)); }
  /// Makes it when there is none.
  std::int32_t find_or_make(const Eigen::Vector3i& at, std::int64_t fusion);

  /// Removes those for which `gone` says so; the others keep their order and get new numbers.
  void remove(const std::function<bool(const Entry&)>& gone);
  /// When there are more than `most`, removes the farthest from a point (m) until a tenth is free. Returns
  /// how many.
  std::size_t keep_near(const Eigen::Vector3f& point, std::size_t most);

  std::size_t memory_bytes() const;

 private:
  float voxel_size_, truncation_;
  std::vector<Entry> entries_;
  VoxelIndex index_;
};

/// Whether nobody's look is in it any more.
bool is_empty(const VoxelBlock& block);

}  // namespace lcmslam
