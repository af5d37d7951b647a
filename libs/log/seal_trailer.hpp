#pragma once
// What a sealed message carries behind its LCM type: a trailer that decoders of LCM do not look at. The bytes
// alone; who makes and checks them is runtime/seal.hpp.

#include <array>
#include <cstdint>
#include <cstring>

namespace lcmslam::seal {

// At the end of the message, in this order; numbers big-endian, as LCM's are.
constexpr std::size_t mark_size = 8, number_size = 8, hash_size = 16;
constexpr std::size_t trailer_size = mark_size + 2 * number_size + hash_size;
constexpr std::array<std::uint8_t, mark_size> mark = {'L', 'C', 'M', 'S', 'E', 'A', 'L', '1'};
// int64 sender, int64 time (us since 1970, grows with each message of the sender), then the hash.

/// Bytes of the message without its trailer; `size` where it has none.
inline std::size_t size_within(const std::uint8_t* data, std::size_t size) {
  if (size < trailer_size) return size;
  return std::memcmp(data + size - trailer_size, mark.data(), mark_size) == 0 ? size - trailer_size : size;
}

}  // namespace lcmslam::seal
