#include <lcmslam/log/log_format.hpp>

#include <algorithm>
#include <cstring>

#include <lcmslam/log/seal_trailer.hpp>

namespace lcmslam::log_format {
namespace {

constexpr std::uint8_t sync_bytes[4] = {0xED, 0xA1, 0xDA, 0x01};

std::uint64_t read_unsigned(const std::uint8_t* at, int bytes) {
  std::uint64_t value = 0;
  for (int i = 0; i < bytes; ++i) value = (value << 8) | at[i];
  return value;
}

std::int64_t read_length(const std::uint8_t* at) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(read_unsigned(at, 4)));
}

std::uint8_t* write_unsigned(std::uint8_t* at, std::uint64_t value, int bytes) {
  for (int i = bytes - 1; i >= 0; --i) *at++ = static_cast<std::uint8_t>(value >> (8 * i));
  return at;
}

}  // namespace

bool follows_event(Bytes bytes, std::uint64_t offset) {
  if (offset > bytes.size) return false;
  const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(4, bytes.size - offset));
  return n == 0 || std::memcmp(bytes.data + offset, sync_bytes, n) == 0;
}

std::uint64_t find_sync(Bytes bytes, std::uint64_t from, std::uint64_t to) {
  const std::uint64_t end = std::min(bytes.size, to <= bytes.size ? to + 3 : to);
  if (from >= end) return bytes.size;
  const void* found = memmem(bytes.data + from, end - from, sync_bytes, sizeof sync_bytes);
  if (found == nullptr) return bytes.size;
  return static_cast<std::uint64_t>(static_cast<const std::uint8_t*>(found) - bytes.data);
}

std::optional<Header> header_at(Bytes bytes, std::uint64_t offset) {
  if (offset > bytes.size || bytes.size - offset < header_size) return std::nullopt;
  const std::uint8_t* at = bytes.data + offset;
  const std::int64_t channel_size = read_length(at + 20), data_size = read_length(at + 24);
  const bool sane = read_unsigned(at, 4) == sync_word && channel_size >= 1 &&
                    channel_size <= longest_channel && data_size >= 0 && data_size <= largest_data;
  if (!sane) return std::nullopt;
  const std::uint64_t there =
      std::min(static_cast<std::uint64_t>(channel_size), bytes.size - offset - header_size);
  if (std::memchr(at + header_size, 0, there) != nullptr) return std::nullopt;
  return Header{offset, static_cast<std::int64_t>(read_unsigned(at + 4, 8)),
                static_cast<std::int64_t>(read_unsigned(at + 12, 8)),
                static_cast<std::uint64_t>(channel_size), static_cast<std::uint64_t>(data_size)};
}

LogEventView view(Bytes bytes, const Header& header) {
  const std::uint8_t* channel = bytes.data + header.offset + header_size;
  const std::uint8_t* data = channel + header.channel_size;
  const std::size_t size = seal::size_within(data, header.data_size);
  return {header.number,
          header.timestamp,
          {reinterpret_cast<const char*>(channel), header.channel_size},
          data,
          size,
          header.offset,
          header.data_size - size};
}

void write_header(std::uint8_t* to, const Header& header) {
  to = write_unsigned(to, sync_word, 4);
  to = write_unsigned(to, static_cast<std::uint64_t>(header.number), 8);
  to = write_unsigned(to, static_cast<std::uint64_t>(header.timestamp), 8);
  to = write_unsigned(to, header.channel_size, 4);
  write_unsigned(to, header.data_size, 4);
}

}  // namespace lcmslam::log_format
