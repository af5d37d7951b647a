#pragma once
// What came from each sender of a channel, by its numbering.

#include <cstdint>
#include <map>
#include <set>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// What was received on one channel from one sender.
struct InputCount {
  std::int64_t received = 0;
  std::int64_t bytes = 0;
  std::int64_t lost = 0;  ///< gaps in seq
  std::int64_t duplicates = 0;
  std::int64_t reordered = 0;  ///< came after a later one: taken for lost until then
  std::int64_t last_seq = -1;
  Utime last_utime = 0;

  /// Follows the sender's numbering. `known_missing` messages before this one arrived but their numbers could
  /// not be read (decode errors): they are not lost. A `utime` far before the last one's together with a
  /// number that does not rise is a log that is played again: the numbering begins anew.
  void follow(std::int64_t seq, std::int64_t known_missing = 0, Utime utime = 0);

  /// Adds up all but the last number and time.
  void add(const InputCount& other);

 private:
  std::set<std::int64_t> missing_;  // numbers taken for lost, the newest of them
  Utime numbered_utime_ = 0;        // of the last message that was followed
};

/// Each call of a tool is another sender, and there is garbage: of many senders the one that was not heard
/// for longest makes room for a new one, and its counts stay in a sum.
class SenderCounts {
 public:
  /// Of who is heard now; valid until the next call.
  InputCount& of(std::int64_t sender);

  const std::map<std::int64_t, InputCount>& known() const { return counts_; }
  const InputCount& forgotten() const { return forgotten_; }
  /// The known ones; what was forgotten stands at 0, with those that do not say who they are.
  std::map<std::int64_t, InputCount> table() const;
  InputCount total() const;

 private:
  std::map<std::int64_t, InputCount> counts_;
  std::map<std::int64_t, std::uint64_t> heard_;  // when, by turns: their own times may be anything
  std::uint64_t turn_ = 0;
  InputCount forgotten_;
};

}  // namespace lcmslam
