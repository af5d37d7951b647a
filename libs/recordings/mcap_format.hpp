#pragma once
// Numbers of the MCAP format (mcap.dev/spec): a file is the magic, records, the magic; a record is one byte
// that says which, its length in 8 bytes, its content; numbers are little-endian.

#include <cstdint>
#include <string_view>

namespace lcmslam::mcap {

using namespace std::string_view_literals;
constexpr std::string_view magic = "\x89MCAP0\r\n"sv;
constexpr std::size_t record_head = 9;
constexpr std::size_t footer_size = 20;

enum class Record : std::uint8_t {
  header = 1,
  footer,
  schema,
  channel,
  message,
  chunk,
  message_index,
  chunk_index,
  attachment,
  attachment_index,
  statistics,
  metadata,
  metadata_index,
  summary_offset,
  data_end
};

}  // namespace lcmslam::mcap
