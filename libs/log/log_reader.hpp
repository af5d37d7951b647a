#pragma once
// Reads .lcmlog files of any size and in any condition.

#include <memory>

#include <lcmslam/log/event_judge.hpp>

namespace lcmslam {

/// A range of the file that holds no whole event.
struct LogDamage {
  std::uint64_t begin = 0, end = 0;  ///< bytes
  std::string reason;
  std::int64_t lost = -1;  ///< events, by the numbers around it; -1: they do not tell
};

/// Gives every whole event in the file's order, and lists what is damaged. Nothing is allocated for what a
/// length field claims.
class LogReader {
 public:
  /// Throws std::runtime_error, naming the file, when it is missing, empty, a folder, or no log (no sync
  /// word in it). The file must not be made shorter while it is read.
  explicit LogReader(const std::string& file, WholenessCheck check = nullptr);
  /// Reads from memory, which must stay. No sync word in it: no events.
  LogReader(const std::uint8_t* data, std::size_t size, WholenessCheck check = nullptr);
  ~LogReader();
  LogReader(const LogReader&) = delete;
  LogReader& operator=(const LogReader&) = delete;

  std::optional<LogEvent> next();
  /// The same without a copy.
  std::optional<LogEventView> next_view();

  /// To the file's begin.
  void rewind();
  /// To the first event, in the file's order, that is not before the time.
  void seek(Utime timestamp);

  /// Found so far, in the file's order; each once, however often it was passed.
  const std::vector<LogDamage>& damages() const { return damages_; }

  std::uint64_t size() const { return bytes_.size; }
  std::uint64_t position() const { return at_; }

 private:
  void skip_damage();
  void lose(std::uint64_t end, const std::string& reason, bool framed);
  void accept(const log_format::Header& header);

  class Mapping;
  std::unique_ptr<Mapping> mapping_;
  log_format::Bytes bytes_;
  EventJudge judge_;
  std::uint64_t at_ = 0;
  std::uint64_t passed_ = 0;                // up to here damage has been listed
  std::optional<std::int64_t> last_;        // number of the last whole event
  std::optional<std::int64_t> contiguous_;  // the same if it ends at at_
  std::size_t counted_ = 0;                 // damages whose losses are known
  std::vector<LogDamage> damages_;
};

}  // namespace lcmslam
