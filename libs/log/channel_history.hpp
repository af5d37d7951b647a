#pragma once
// What a log's channels carried so far: tells whether bytes look like one more message of theirs, for
// types that nobody knows.

#include <map>
#include <string>

#include <lcmslam/log/log_event.hpp>

namespace lcmslam {

class ChannelHistory {
 public:
  void add(const LogEventView& event);

  /// The channel was seen, its last message began with the same fingerprint, and if all of them had one
  /// size then this one has it too.
  bool resembles(std::string_view channel, const std::uint8_t* data, std::size_t size) const;

 private:
  struct Kind {
    std::uint64_t fingerprint = 0;
    std::size_t size = 0;
    std::int64_t of_this_size = 0;  // messages in a row
  };
  std::map<std::string, Kind, std::less<>> kinds_;
};

}  // namespace lcmslam
