#pragma once
// Writes MCAP files with chunks, message indexes, summary and CRCs.

#include <cstdio>
#include <map>
#include <memory>
#include <vector>

#include <lcmslam/files/part_file.hpp>
#include <lcmslam/recordings/byte_reader.hpp>
#include <lcmslam/recordings/byte_writer.hpp>

namespace lcmslam {

/// Writes a part file (files/part_file.hpp), which becomes FILE when closed. Without close() nothing stays.
/// All functions throw std::runtime_error, naming the file, when a byte cannot be written.
class McapWriter {
 public:
  struct Options {
    std::string compression = "zstd";      ///< of chunks: "zstd", "lz4" or ""
    std::size_t chunk_size = 1024 * 1024;  ///< bytes, from which on a chunk is written
  };

  McapWriter(const std::string& file, const Options& options);
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// A topic of messages in CDR, its type defined in ROS 2's language ("ros2msg"). Gives its channel.
  std::uint16_t add_channel(const std::string& topic, const std::string& type, const std::string& definition);

  /// Times in ns: when it was logged, and when it was measured.
  void write(std::uint16_t channel, std::int64_t log_time, std::int64_t publish_time, ByteView message);

  void close();

  std::uint64_t bytes() const { return position_; }

 private:
  struct Channel {
    std::vector<std::uint8_t> schema_record, channel_record;
    std::uint32_t sequence = 0;
    std::uint64_t messages = 0;
  };
  struct IndexEntry {
    std::int64_t time = 0;
    std::uint64_t offset = 0;
  };
  struct Times {
    std::int64_t first = 0, last = 0;
    bool any = false;
    void add(std::int64_t time);
  };

  void write_chunk();
  void write_summary();
  void write_bytes(ByteView bytes);

  std::string file_;
  Options options_;
  std::unique_ptr<PartFile> part_;
  std::FILE* stream_ = nullptr;
  std::uint64_t position_ = 0;
  std::uint32_t crc_ = 0;  // of all bytes since it was set to 0

  std::vector<Channel> channels_;
  std::map<std::string, std::uint16_t> schemas_;  // by type
  Times times_;

  ByteWriter chunk_;  // the records of the chunk that is being filled
  Times chunk_times_;
  std::map<std::uint16_t, std::vector<IndexEntry>> chunk_index_;
  std::vector<std::vector<std::uint8_t>> chunk_index_records_;  // of the chunks so far
};

}  // namespace lcmslam
