#pragma once
// One message of an .lcmlog file, LCM's format for recorded messages.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

struct LogEvent {
  std::int64_t number = 0;  ///< counts the file's events; writers number them one by one
  Utime timestamp = 0;      ///< us, when it was logged
  std::string channel;
  std::vector<std::uint8_t> data;
};

/// The same where it stands in the file: valid as long as its reader.
struct LogEventView {
  std::int64_t number = 0;
  Utime timestamp = 0;
  std::string_view channel;
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;
  std::uint64_t offset = 0;  ///< of its header in the file
  std::size_t seal = 0;      ///< bytes behind the data (seal_trailer.hpp), which are none of the message

  LogEvent copy() const { return {number, timestamp, std::string(channel), {data, data + size}}; }
};

/// b - a in us; the largest or smallest number where that is beyond: times in damaged logs may be any.
inline Utime time_between(Utime a, Utime b) {
  Utime difference = 0;
  if (__builtin_sub_overflow(b, a, &difference)) return b > a ? INT64_MAX : INT64_MIN;
  return difference;
}

}  // namespace lcmslam
