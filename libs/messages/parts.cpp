#include <lcmslam/messages/parts.hpp>

#include <algorithm>
#include <stdexcept>

#include <lcmslam/messages/schema.hpp>

namespace lcmslam {
namespace {

const std::string suffix = "_PART";
constexpr std::size_t longest_channel = 63;  // characters, LCM's
constexpr std::size_t most_waiting = 8;      // messages; more are those of senders that went away

void check(const part_t& part, std::size_t largest_message) {
  const bool fits = part.n_parts > 0 && part.part >= 0 && part.part < part.n_parts && part.total_size > 0 &&
                    static_cast<std::size_t>(part.total_size) <= largest_message &&
                    part.n_parts <= part.total_size && part.size > 0 && part.size <= part.total_size;
  if (!fits)
    throw DecodeError("part_t: part " + std::to_string(part.part) + " of " + std::to_string(part.n_parts) +
                      " with " + std::to_string(part.size) + " of " + std::to_string(part.total_size) +
                      " bytes cannot be");
  if (part.channel.empty() || part.channel.size() > longest_channel || is_part_channel(part.channel))
    throw DecodeError("part_t: '" + part.channel.substr(0, longest_channel) +
                      "' cannot be the channel of a whole message");
}

}  // namespace

std::string part_channel(const std::string& channel) {
  return channel + suffix;
}

bool is_part_channel(const std::string& channel) {
  return channel.size() > suffix.size() &&
         channel.compare(channel.size() - suffix.size(), suffix.size(), suffix) == 0;
}

std::vector<part_t> split_message(const std::string& channel, const std::vector<std::uint8_t>& bytes,
                                  Utime utime, std::int64_t message, std::size_t part_size) {
  if (part_size == 0) throw std::invalid_argument("split_message: part_size must be positive");
  std::vector<part_t> parts;
  for (std::size_t begin = 0; begin < bytes.size(); begin += part_size) {
    const std::size_t end = std::min(begin + part_size, bytes.size());
    part_t part;
    part.utime = utime;
    part.channel = channel;
    part.message = message;
    part.part = static_cast<std::int32_t>(parts.size());
    part.total_size = static_cast<std::int32_t>(bytes.size());
    part.data.assign(bytes.begin() + static_cast<std::ptrdiff_t>(begin),
                     bytes.begin() + static_cast<std::ptrdiff_t>(end));
    part.size = static_cast<std::int32_t>(part.data.size());
    parts.push_back(std::move(part));
  }
  for (part_t& part : parts) part.n_parts = static_cast<std::int32_t>(parts.size());
  return parts;
}

std::optional<PartAssembler::Whole> PartAssembler::add(const part_t& part) {
  check(part, most_bytes_);
  const Key key{part.sender, part.channel, part.message};
  auto found = std::find_if(waiting_.begin(), waiting_.end(), [&](const Waiting& w) { return w.key == key; });
  if (found == waiting_.end()) {
    if (waiting_.size() == most_waiting) give_up_oldest();
    waiting_.push_back({key, part.n_parts, part.total_size, 0, {}});
    found = std::prev(waiting_.end());
  }
  if (found->n_parts != part.n_parts || found->total_size != part.total_size)
    throw DecodeError("part_t: the pieces of one message disagree on its size");
  if (found->parts.count(part.part) == 0) {
    // Else a sender could make us keep n_parts times total_size bytes.
    if (part.data.size() > static_cast<std::size_t>(part.total_size) - found->received)
      throw DecodeError("part_t: the pieces of a message are more than its size");
    found->received += part.data.size();
    found->parts.emplace(part.part, part.data);
  }
  if (found->parts.size() < static_cast<std::size_t>(part.n_parts)) {
    while (waiting_bytes() > most_bytes_) give_up_oldest();
    return std::nullopt;
  }

  Whole whole{part.channel, part.utime, {}};
  for (const auto& [number, data] : found->parts)
    whole.bytes.insert(whole.bytes.end(), data.begin(), data.end());
  const bool complete = whole.bytes.size() == static_cast<std::size_t>(part.total_size);
  // Older ones of this sender and channel can no longer become complete: senders keep the order.
  incomplete_ += std::count_if(waiting_.begin(), found, [&](const Waiting& w) {
    return w.key.sender == key.sender && w.key.channel == key.channel;
  });
  waiting_.erase(std::remove_if(waiting_.begin(), std::next(found),
                                [&](const Waiting& w) {
                                  return w.key.sender == key.sender && w.key.channel == key.channel;
                                }),
                 std::next(found));
  if (!complete) throw DecodeError("part_t: the pieces of a message do not add up to its size");
  return whole;
}

std::size_t PartAssembler::waiting_bytes() const {
  constexpr std::size_t node = 128;  // bytes of the map's node and of both allocations, about
  std::size_t bytes = 0;
  for (const Waiting& waiting : waiting_) bytes += waiting.received + node * waiting.parts.size();
  return bytes;
}

void PartAssembler::give_up_oldest() {
  waiting_.pop_front();
  ++incomplete_;
}

}  // namespace lcmslam
