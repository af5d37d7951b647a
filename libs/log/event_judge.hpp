#pragma once
// Decides whether the event at a place in a log is whole.
//
// An event whose end meets the next header, one number further, is whole. Otherwise something is
// damaged: this event (its own length, or bytes of it cut out: then the next header lies inside the range
// that it claims), or what comes after it (then this event is whole and must be kept). Event numbers,
// the chain of the headers inside, the message's own layout and the channel's earlier messages decide; where
// nothing does, the event is kept.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/log/channel_history.hpp>
#include <lcmslam/log/log_format.hpp>

namespace lcmslam {

enum class Wholeness { whole, damaged, undecided };

/// Looks at a message itself: `undecided` for types that it does not know.
using WholenessCheck =
    std::function<Wholeness(std::string_view channel, const std::uint8_t* data, std::size_t size)>;

class EventJudge {
 public:
  EventJudge(log_format::Bytes bytes, WholenessCheck check) : bytes_(bytes), check_(std::move(check)) {}

  struct Verdict {
    bool whole = true;
    bool framed = true;        ///< where the next event begins is known
    std::uint64_t resume = 0;  ///< where to look for the next event
    std::string reason;        ///< of damage
  };

  /// `header` is sane and all its bytes are there. `previous` is the number of the event that ends right
  /// before it, if that one is whole.
  Verdict judge(const log_format::Header& header, std::optional<std::int64_t> previous) const;

  /// To be called for each event that was found whole.
  void accepted(const LogEventView& event) { history_.add(event); }

 private:
  /// Offsets in a range that were walked over, in vain: walking from each would take for ever in a file that
  /// is made for it.
  class Walked {
   public:
    Walked(std::uint64_t begin, std::uint64_t end) : begin_(begin), end_(end) {}
    /// False: it was there already.
    bool insert(std::uint64_t offset);

   private:
    std::uint64_t begin_, end_;
    std::vector<bool> offsets_;
  };
  std::optional<std::uint64_t> next_event_inside(const log_format::Header& header, bool followed) const;
  bool chain_leaves(std::uint64_t from, std::uint64_t end, Walked& walked) const;
  bool chain_joins(log_format::Header inner, const log_format::Header& outer, Walked& walked) const;
  bool is_shortened(const LogEventView& event, std::uint64_t next) const;
  Wholeness check(std::string_view channel, const std::uint8_t* data, std::size_t size) const;

  log_format::Bytes bytes_;
  WholenessCheck check_;
  ChannelHistory history_;
};

}  // namespace lcmslam
