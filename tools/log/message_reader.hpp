#pragma once
// The messages of a log, whatever way they were logged: those in pieces joined, damaged ones left out unless
// the caller counts them himself.

#include <string>

#include <lcmslam/log/log_reader.hpp>
#include "tools/log/part_joiner.hpp"

namespace lcmslam {

class MessageReader {
 public:
  /// Throws std::runtime_error when the file is no log.
  /// `robot`: of a log of several robots only this one's channels, without its name.
  explicit MessageReader(const std::string& file, const std::string& robot = "")
      : MessageReader(file, robot, true) {}
  /// Messages that do not decode come, too.
  static MessageReader of_all(const std::string& file) { return {file, "", false}; }

  /// Valid until the next call.
  std::optional<LogEventView> next();

  std::int64_t read() const { return read_; }      ///< whole events so far
  std::int64_t joined() const { return joined_; }  ///< messages that were in pieces, so far
  std::int64_t incomplete() const;                 ///< messages that lack pieces, so far
  std::vector<LogDamage> damages() const;          ///< found so far

 private:
  MessageReader(const std::string& file, const std::string& robot, bool whole);

  LogReader reader_;
  std::string prefix_;  // "dora/"
  PartJoiner joiner_;
  LogEvent whole_;
  std::int64_t read_ = 0, joined_ = 0;
  std::vector<LogDamage> bad_pieces_;
};

/// What a log holds, without a look into its messages but for pieces.
struct LogContents {
  Utime first = 0;                 ///< log time of the first event
  std::set<std::string> channels;  ///< of whole messages; pieces count as the channel that they belong to
};
LogContents scan_log(const std::string& file, const std::string& robot = "");

}  // namespace lcmslam
