#include <lcmslam/surface/voxel_blocks.hpp>

#include <algorithm>

namespace lcmslam {

std::int32_t VoxelBlocks::find_or_make(const Eigen::Vector3i& at, std::int64_t fusion) {
  const auto next = static_cast<std::int32_t>(entries_.size());
  const std::int32_t found = index_.insert(voxel_key(at), next);
  if (found == next) entries_.push_back({at, fusion, fusion, std::make_unique<VoxelBlock>()});
  return found;
}

void VoxelBlocks::remove(const std::function<bool(const Entry&)>& gone) {
  const auto end = std::remove_if(entries_.begin(), entries_.end(), gone);
  if (end == entries_.end()) return;
  entries_.erase(end, entries_.end());
  index_.clear(entries_.size());
  for (std::size_t i = 0; i < entries_.size(); ++i)
    index_.insert(voxel_key(entries_[i].at), static_cast<std::int32_t>(i));
}

std::size_t VoxelBlocks::keep_near(const Eigen::Vector3f& point, std::size_t most) {
  const std::size_t before = entries_.size();
  if (before <= most) return 0;
  std::vector<float> distances;
  distances.reserve(entries_.size());
  for (const Entry& entry : entries_) distances.push_back((centre(entry) - point).squaredNorm());
  const auto last = distances.begin() + static_cast<std::ptrdiff_t>(most - most / 10);
  std::nth_element(distances.begin(), last, distances.end());
  const float limit = *last;
  remove([&](const Entry& entry) { return (centre(entry) - point).squaredNorm() >= limit; });
  return before - entries_.size();
}

std::size_t VoxelBlocks::memory_bytes() const {
  return entries_.size() * sizeof(VoxelBlock) + entries_.capacity() * sizeof(Entry) + index_.memory_bytes();
}

bool is_empty(const VoxelBlock& block) {
  return std::all_of(std::begin(block.weight), std::end(block.weight),
                     [](std::uint16_t w) { return w == 0; });
}

}  // namespace lcmslam
