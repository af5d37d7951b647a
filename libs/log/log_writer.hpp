#pragma once
// Writes .lcmlog files that stock LCM reads.

#include <cstdio>
#include <memory>

#include <lcmslam/files/part_file.hpp>
#include <lcmslam/log/log_event.hpp>

namespace lcmslam {

/// Writes a part file (files/part_file.hpp), which becomes FILE when closed, so that FILE is whole whatever
/// happens. Without close() nothing stays. All functions throw std::runtime_error, naming the file, when a
/// byte cannot be written.
class LogWriter {
 public:
  explicit LogWriter(const std::string& file);
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  /// Numbers the event. Throws std::invalid_argument for what LCM could not read: a channel of 0 or more
  /// than 999 bytes or with a NUL, data of more than 2^28 bytes.
  void write(Utime timestamp, std::string_view channel, const std::uint8_t* data, std::size_t size);
  void write(Utime timestamp, std::string_view channel, const std::vector<std::uint8_t>& data) {
    write(timestamp, channel, data.data(), data.size());
  }

  /// The events are on their way to the disk and FILE is there.
  void close();

  std::int64_t events() const { return events_; }
  std::int64_t bytes() const { return bytes_; }

 private:
  void write_bytes(const void* data, std::size_t size);
  [[noreturn]] void fail();

  std::string file_;
  std::unique_ptr<PartFile> part_;
  std::FILE* stream_ = nullptr;
  std::int64_t events_ = 0;
  std::int64_t bytes_ = 0;
};

}  // namespace lcmslam
