#pragma once
// What came from the network and was not taken, counted by reason.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace lcmslam {

/// Why a datagram, or a message in fragments, was not taken.
enum class Refusal : std::size_t {
  foreign,          ///< its source is no machine that we listen to
  not_group,        ///< addressed to this machine and not to the multicast group
  unknown_magic,    ///< no datagram of LCM
  cut_short,        ///< ends within its header
  bad_channel,      ///< the channel's name is empty, too long or has no end
  too_large,        ///< claims to belong to a larger message than we hold
  bad_number,       ///< fragment 5 of 3, or more fragments than bytes
  nothing_carried,  ///< a fragment without data
  beyond_end,       ///< data that reach beyond the end of their message
  contradiction,    ///< fragments that disagree about their message, overlap or leave holes
  incomplete,       ///< a message given up because fragments were missing
  unsealed,         ///< a message without the seal of this bus's key (seal.hpp)
  replayed,         ///< sealed, but not for the first time here
  other_time,       ///< sealed by this bus's key, but at a time that is far from this machine's
};
constexpr std::size_t refusal_kinds = 14;

/// In words.
const char* describe(Refusal refusal);
/// The same of messages of another time: `age`, s ago by their sender's clock, negative: ahead of ours.
std::string describe_other_time(double age);

struct Refusals {
  std::array<std::int64_t, refusal_kinds> counts{};
  std::string last_stranger;   ///< "10.0.0.7:4711", of the last datagram that was foreign or not_group
  std::string last_malformed;  ///< why, in words
  std::string last_unsealed;   ///< channel of the last message that unsealed() counts
  double last_age = 0;         ///< s, of the last one of another time

  std::int64_t of(Refusal refusal) const { return counts[static_cast<std::size_t>(refusal)]; }
  /// foreign and not_group.
  std::int64_t foreign() const;
  /// unsealed, replayed and other_time.
  std::int64_t unsealed() const;
  /// All that is none of the others.
  std::int64_t malformed() const;
  std::int64_t incomplete() const { return of(Refusal::incomplete); }
  bool any() const { return foreign() + unsealed() + malformed() + incomplete() > 0; }

  /// "3 packets of strangers (last 10.0.0.7:4711), 1 malformed (no datagram of LCM)": what is not 0; empty
  /// when nothing was refused.
  std::string text() const;
};

}  // namespace lcmslam
