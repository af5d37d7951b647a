#pragma once
// Integer voxel coordinates and a flat hash table from voxels to indices. The table is only ever
// looked up, never iterated, so that results do not depend on its layout.

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace lcmslam {

/// Packs three coordinates of 21 bits each; the caller keeps them within +-2^20.
inline std::uint64_t voxel_key(const Eigen::Vector3i& v) {
  constexpr int offset = 1 << 20;
  constexpr std::uint64_t mask = (1u << 21) - 1;
  const auto part = [](int c) { return static_cast<std::uint64_t>(c + offset) & mask; };
  return part(v.x()) << 42 | part(v.y()) << 21 | part(v.z());
}

/// Voxel of a point, for 1 / voxel size.
inline Eigen::Vector3i voxel_of(const Eigen::Vector3f& point, float inverse_size) {
  const auto cell = [&](float c) { return static_cast<int>(std::floor(c * inverse_size)); };
  return {cell(point.x()), cell(point.y()), cell(point.z())};
}

/// True when the point is finite and its voxel can be packed.
inline bool voxel_exists(const Eigen::Vector3f& point, float inverse_size) {
  const float limit = 1e6f;  // below 2^20
  return point.allFinite() && (point * inverse_size).cwiseAbs().maxCoeff() < limit;
}

class VoxelIndex {
 public:
  static constexpr std::int32_t none = -1;

  explicit VoxelIndex(std::size_t expected = 64) { clear(expected); }

  void clear(std::size_t expected = 64) {
    std::size_t capacity = 64;
    while (capacity < 2 * expected) capacity *= 2;
    slots_.assign(capacity, Slot{});
    used_ = 0;
  }

  std::int32_t find(std::uint64_t key) const {
    for (std::size_t i = home(key);; i = (i + 1) & (slots_.size() - 1)) {
      if (slots_[i].value == none) return none;
      if (slots_[i].key == key) return slots_[i].value;
    }
  }

  std::size_t memory_bytes() const { return slots_.capacity() * sizeof(Slot); }

  /// The value stored for the key, which becomes `value` when there was none.
  std::int32_t insert(std::uint64_t key, std::int32_t value) {
    if (2 * (used_ + 1) > slots_.size()) grow();
    for (std::size_t i = home(key);; i = (i + 1) & (slots_.size() - 1)) {
      if (slots_[i].value == none) {
        slots_[i] = {key, value};
        ++used_;
        return value;
      }
      if (slots_[i].key == key) return slots_[i].value;
    }
  }

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::int32_t value = none;
  };

  // Fibonacci hashing; the multiplier is 2^64 / golden ratio.
  std::size_t home(std::uint64_t key) const {
    key ^= key >> 29;
    return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15ULL) >> 20) & (slots_.size() - 1);
  }

  void grow() {
    std::vector<Slot> old(slots_.size() * 2);
    old.swap(slots_);
    used_ = 0;
    for (const Slot& s : old)
      if (s.value != none) insert(s.key, s.value);
  }

  std::vector<Slot> slots_;
  std::size_t used_ = 0;
};

}  // namespace lcmslam
