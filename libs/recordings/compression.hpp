#pragma once
// The compressions of chunks in bags and MCAP files.

#include <cstdint>
#include <string>
#include <vector>

#include <lcmslam/recordings/byte_reader.hpp>

namespace lcmslam {

/// Unpacks by "lz4" (LZ4's frame format), "zstd", "bz2", or copies by "" and "none". Memory is taken as bytes
/// come out, not for what a length claims. Throws RecordingError when the bytes are damaged, the
/// compression is another, or other than `size` bytes come out.
std::vector<std::uint8_t> unpack(const std::string& compression, ByteView packed, std::uint64_t size);

/// Packs by "zstd", "lz4" or "". Throws std::invalid_argument for another.
std::vector<std::uint8_t> pack(const std::string& compression, ByteView bytes);

/// CRC-32 of zlib and Ethernet; `before` continues that of the bytes before.
std::uint32_t crc32(ByteView bytes, std::uint32_t before = 0);

}  // namespace lcmslam
