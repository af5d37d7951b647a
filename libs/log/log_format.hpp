#pragma once
// How an event lies in an .lcmlog file: a big-endian header of 28 bytes (sync word, int64 number, int64
// timestamp in us, int32 length of the channel, int32 length of the data), channel, data; the next event
// follows at once.

#include <cstddef>
#include <cstdint>
#include <optional>

#include <lcmslam/log/log_event.hpp>

namespace lcmslam::log_format {

constexpr std::uint32_t sync_word = 0xEDA1DA01;
constexpr std::size_t header_size = 28;
constexpr std::int64_t longest_channel = 999;     // bytes, as stock LCM reads
constexpr std::int64_t largest_data = 1LL << 28;  // bytes, LCM's limit of a message

/// The bytes of a whole log.
struct Bytes {
  const std::uint8_t* data = nullptr;
  std::uint64_t size = 0;
};

/// What a header says. Its lengths are within the limits above, but the bytes need not be there.
struct Header {
  std::uint64_t offset = 0;
  std::int64_t number = 0;
  Utime timestamp = 0;
  std::uint64_t channel_size = 0;
  std::uint64_t data_size = 0;

  std::uint64_t end() const { return offset + header_size + channel_size + data_size; }
};

/// A sync word at this place, or at the end of the file as much of one as the file still holds (also
/// nothing at all).
bool follows_event(Bytes bytes, std::uint64_t offset);

/// First whole sync word that begins in [from, to); bytes.size when there is none.
std::uint64_t find_sync(Bytes bytes, std::uint64_t from, std::uint64_t to);

/// The header at this place if it is sane: sync word, lengths within the limits, no NUL in the channel.
std::optional<Header> header_at(Bytes bytes, std::uint64_t offset);

/// The event of a header whose bytes are all there; its data without the seal that they may carry.
LogEventView view(Bytes bytes, const Header& header);

/// Writes the 28 bytes.
void write_header(std::uint8_t* to, const Header& header);

}  // namespace lcmslam::log_format
