#include <lcmslam/map_layers/packed_cells.hpp>

#include <algorithm>
#include <cstring>

namespace lcmslam {
namespace {

constexpr int most_values = 16;
using Indices = std::array<std::uint8_t, block_cells>;

/// The different values of a block in the order in which they come, and which of them each cell has.
/// Returns how many there are; most_values + 1 as soon as there are more.
int index_values(const BlockLogOdds& cells, std::array<LogOdds, most_values>& values, Indices& indices) {
  std::array<std::uint8_t, 256> index_of;
  index_of.fill(255);
  int count = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    std::uint8_t& index = index_of[static_cast<std::uint8_t>(cells[i])];
    if (index == 255) {
      if (count == most_values) return most_values + 1;
      values[static_cast<std::size_t>(count)] = cells[i];
      index = static_cast<std::uint8_t>(count++);
    }
    indices[i] = index;
  }
  return count;
}

// A byte holds cells that are a whole part of the block apart, so that neighbours are in neighbouring bytes
// and the loops over bytes are plain.
constexpr std::size_t bytes_for(int bits) {
  return static_cast<std::size_t>(bits) * block_cells / 8;
}

}  // namespace

PackedCells::PackedCells(const PackedCells& other) : value_(other.value_) {
  reserve(other.bits_);
  if (!uniform()) std::copy_n(other.bytes_.get(), size(), bytes_.get());
}

void PackedCells::reserve(int bits) {
  if (bits == bits_) return;
  bytes_.reset(bits == 0 ? nullptr : new std::uint8_t[size_of(bits)]);
  bits_ = static_cast<std::uint8_t>(bits);
}

void PackedCells::fill(LogOdds value) {
  reserve(0);
  value_ = value;
}

LogOdds PackedCells::at(int place) const {
  if (uniform()) return value_;
  if (bits_ == 8) return static_cast<LogOdds>(bytes_[static_cast<std::size_t>(place)]);
  const std::size_t n = bytes_for(bits_), i = static_cast<std::size_t>(place);
  const int byte = bytes_[values_of(bits_) + i % n];
  const int index = byte >> (static_cast<int>(i / n) * bits_) & ((1 << bits_) - 1);
  return static_cast<LogOdds>(bytes_[static_cast<std::size_t>(index)]);
}

void PackedCells::unpack(BlockLogOdds& cells) const {
  if (uniform()) return cells.fill(value_);
  if (bits_ == 8) {
    std::memcpy(cells.data(), bytes_.get(), cells.size());
    return;
  }
  const std::size_t n = bytes_for(bits_);
  const std::uint8_t* values = bytes_.get();
  const std::uint8_t* packed = values + values_of(bits_);
  const int mask = (1 << bits_) - 1;
  LogOdds* cell = cells.data();
  for (int shift = 0; shift < 8; shift += bits_)
    for (std::size_t i = 0; i < n; ++i) *cell++ = static_cast<LogOdds>(values[packed[i] >> shift & mask]);
}

void PackedCells::pack(const BlockLogOdds& cells) {
  std::array<LogOdds, most_values> values{};
  Indices indices;
  const int count = index_values(cells, values, indices);
  if (count == 1) return fill(cells[0]);
  const int bits = count <= 2 ? 1 : count <= 4 ? 2 : count <= most_values ? 4 : 8;
  reserve(bits);
  if (bits == 8) {
    std::memcpy(bytes_.get(), cells.data(), cells.size());
    return;
  }
  const std::size_t n = bytes_for(bits);
  std::memcpy(bytes_.get(), values.data(), values_of(bits));
  std::uint8_t* packed = bytes_.get() + values_of(bits);
  std::memcpy(packed, indices.data(), n);
  for (int k = 1; k < 8 / bits; ++k) {
    const std::uint8_t* part = indices.data() + static_cast<std::size_t>(k) * n;
    for (std::size_t i = 0; i < n; ++i)
      packed[i] = static_cast<std::uint8_t>(packed[i] | part[i] << (k * bits));
  }
}

}  // namespace lcmslam
