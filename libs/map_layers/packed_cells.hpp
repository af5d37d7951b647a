#pragma once
// A block's log-odds in few bytes, exactly: most blocks hold few different values, so a cell is an index of
// 1, 2 or 4 bits into them. A block with more than 16 keeps a byte a cell; one with a single value has no
// cells.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>

#include <lcmslam/map_layers/block_table.hpp>

namespace lcmslam {

/// Log-odds of being occupied, in steps of 0.05; above 0: occupied.
using LogOdds = std::int8_t;
constexpr LogOdds unknown_log_odds = -128;
inline LogOdds log_odds(double probability) {
  return static_cast<LogOdds>(std::lround(20 * std::log(probability / (1 - probability))));
}
using BlockLogOdds = std::array<LogOdds, block_cells>;

class PackedCells {
 public:
  PackedCells() = default;  ///< all unknown
  PackedCells(const PackedCells& other);
  PackedCells(PackedCells&&) noexcept = default;
  PackedCells& operator=(PackedCells&&) noexcept = default;

  bool uniform() const { return bits_ == 0; }
  /// What all cells say; only when they say the same.
  LogOdds value() const { return value_; }
  void fill(LogOdds value);

  LogOdds at(int place) const;
  void unpack(BlockLogOdds& cells) const;
  void pack(const BlockLogOdds& cells);
  /// On the heap: the values, then the indices.
  std::size_t size() const { return uniform() ? 0 : size_of(bits_); }

 private:
  static std::size_t values_of(int bits) { return bits < 8 ? std::size_t{1} << bits : 0; }
  static std::size_t size_of(int bits) {
    return values_of(bits) + static_cast<std::size_t>(bits) * block_cells / 8;
  }
  void reserve(int bits);

  std::unique_ptr<std::uint8_t[]> bytes_;
  std::uint8_t bits_ = 0;  // of a cell: 0, 1, 2, 4 or 8
  LogOdds value_ = unknown_log_odds;
};

}  // namespace lcmslam
