#include <lcmslam/log/event_judge.hpp>

namespace lcmslam {

using log_format::find_sync;
using log_format::follows_event;
using log_format::Header;
using log_format::header_at;

namespace {

/// Whether number b comes `steps` after number a; damaged ones may be any.
bool is_after(std::int64_t a, std::int64_t b, std::uint64_t steps) {
  return static_cast<std::uint64_t>(b) - static_cast<std::uint64_t>(a) == steps;
}

}  // namespace

EventJudge::Verdict EventJudge::judge(const Header& header, std::optional<std::int64_t> previous) const {
  const std::uint64_t end = header.end();
  const LogEventView event = view(bytes_, header);
  const Wholeness layout = check(event.channel, event.data, event.size);
  const auto next = header_at(bytes_, end);
  const bool last = bytes_.size - end < log_format::header_size && follows_event(bytes_, end);
  const bool followed = next || last;
  const bool numbered = next && is_after(header.number, next->number, 1);
  if (numbered && layout != Wholeness::damaged) return {true, true, end, ""};

  if (!(followed && layout == Wholeness::whole))
    if (const auto inside = next_event_inside(header, followed))
      return {false, false, *inside, "its length is wrong, or a part of it is missing"};
  if (layout == Wholeness::damaged) {
    const std::uint64_t resume = followed ? end : find_sync(bytes_, header.offset + 4, bytes_.size);
    return {false, followed, resume, "its message is not what its type says"};
  }
  if (followed) {
    const bool out_of_line =
        previous && next && !is_after(*previous, header.number, 1) && is_after(*previous, next->number, 2);
    if (out_of_line)
      return {false, false, end, "its number " + std::to_string(header.number) + " fits neither neighbour"};
    return {true, true, end, ""};
  }
  // The bytes after it belong to nothing. Either they are damaged or it is longer than it says.
  const std::uint64_t after = find_sync(bytes_, end, bytes_.size);
  const auto found = header_at(bytes_, after);
  const bool nothing_between = after == bytes_.size || (found && is_after(header.number, found->number, 1));
  if (layout == Wholeness::undecided && nothing_between && is_shortened(event, after))
    return {false, false, after, "its length is wrong"};
  return {true, true, end, ""};
}

/// The header inside the claimed range that shows the event's end to be wrong. Other sync words there are
/// payload: chance, or a log in a message.
std::optional<std::uint64_t> EventJudge::next_event_inside(const Header& header, bool followed) const {
  const std::uint64_t end = header.end();
  Walked walked(header.offset, end);
  bool first = true;
  for (std::uint64_t at = find_sync(bytes_, header.offset + 4, end); at < end;
       at = find_sync(bytes_, at + 4, end)) {
    const auto inner = header_at(bytes_, at);
    if (!inner) continue;
    if (first && is_after(header.number, inner->number, 1)) return at;
    if (followed ? chain_joins(*inner, header, walked) : chain_leaves(at, end, walked)) return at;
    first = false;
  }
  return std::nullopt;
}

bool EventJudge::Walked::insert(std::uint64_t offset) {
  if (offsets_.empty()) offsets_.resize(end_ - begin_ + 1);
  auto known = offsets_[offset - begin_];
  const bool is_new = !known;
  known = true;
  return is_new;
}

/// Events follow one another from `from` and do not respect `end`.
bool EventJudge::chain_leaves(std::uint64_t from, std::uint64_t end, Walked& walked) const {
  constexpr int long_enough = 10'000;  // events
  for (int i = 0; i < long_enough; ++i) {
    const auto header = header_at(bytes_, from);
    if (!header || header->end() > bytes_.size || !walked.insert(from)) return false;
    from = header->end();
    if (from > end || from == bytes_.size) return follows_event(bytes_, from);
  }
  return true;
}

/// Events follow one another from `inner` to the end of `outer` and are numbered like what comes after it.
bool EventJudge::chain_joins(Header inner, const Header& outer, Walked& walked) const {
  if (inner.number <= outer.number) return false;
  while (inner.end() < outer.end()) {
    if (!walked.insert(inner.offset)) return false;
    const auto next = header_at(bytes_, inner.end());
    if (!next) return false;
    inner = *next;
  }
  const auto after = header_at(bytes_, outer.end());
  return inner.end() == outer.end() && (!after || is_after(inner.number, after->number, 1));
}

/// With the bytes up to `next` as part of its channel or of its data it looks like others of its channel,
/// without them it does not.
bool EventJudge::is_shortened(const LogEventView& event, std::uint64_t next) const {
  const auto begin = static_cast<std::uint64_t>(event.data - bytes_.data);
  const std::uint64_t more = next - begin - event.size;
  const auto looks_right = [&](std::size_t channel_more, std::size_t data_more) {
    const std::string_view channel(event.channel.data(), event.channel.size() + channel_more);
    const std::uint8_t* data = event.data + channel_more;
    const std::size_t size = event.size + data_more;
    return history_.resembles(channel, data, size) || check(channel, data, size) == Wholeness::whole;
  };
  return !looks_right(0, 0) && (looks_right(more, 0) || looks_right(0, more));
}

Wholeness EventJudge::check(std::string_view channel, const std::uint8_t* data, std::size_t size) const {
  return check_ ? check_(channel, data, size) : Wholeness::undecided;
}

}  // namespace lcmslam
