#include <lcmslam/runtime/udpm/reassembly.hpp>

#include <cstdlib>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace lcmslam::udpm {

ReassemblyLimits reassembly_limits() {
  ReassemblyLimits limits;
  const char* text = std::getenv("LCMSLAM_BUS_MEMORY");
  if (text == nullptr || *text == '\0') return limits;
  const std::string value = text;
  const bool digits = value.size() <= 4 && value.find_first_not_of("0123456789") == std::string::npos;
  const std::size_t mebibytes = digits ? std::stoul(value) : 0;
  if (mebibytes < 16 || mebibytes > 4096)  // a message has up to 16
    throw std::invalid_argument("LCMSLAM_BUS_MEMORY: '" + value +
                                "' is not 16 to 4096 (MiB of half messages)");
  limits.bytes = mebibytes << 20U;
  limits.messages = 8 * mebibytes;
  return limits;
}

std::optional<BusMessage> Reassembly::add(const Source& source, const Packet& packet) {
  const Place place = find_or_begin(source, packet);
  keep(*place, packet);
  if (place->fragments.size() == place->count) return join(remove(place));
  while (bytes_ > limits_.bytes || waiting_.size() > limits_.messages)
    give_up(waiting_.begin(), Refusal::incomplete);
  return std::nullopt;
}

Reassembly::Place Reassembly::find_or_begin(const Source& source, const Packet& packet) {
  std::size_t of_this_sender = 0;
  Place oldest = waiting_.end();
  for (Place place = waiting_.begin(); place != waiting_.end(); ++place) {
    if (!(place->source == source)) continue;
    if (place->sequence == packet.sequence) {
      if (place->message_size == packet.message_size && place->count == packet.count) return place;
      give_up(place, Refusal::contradiction);
      break;
    }
    if (of_this_sender++ == 0) oldest = place;
  }
  if (of_this_sender >= limits_.of_a_sender) give_up(oldest, Refusal::incomplete);
  waiting_.push_back({source, packet.sequence, packet.message_size, packet.count});
  return std::prev(waiting_.end());
}

/// A fragment that comes twice replaces the first: it may belong to a new message of a sender that began its
/// numbering anew.
void Reassembly::keep(Waiting& waiting, const Packet& packet) {
  if (packet.number == 0) {
    waiting.channel = packet.channel;
    if (!wanted_(waiting.channel)) drop_data(waiting);
  }
  const auto [at, is_new] = waiting.fragments.try_emplace(packet.number);
  Fragment& fragment = at->second;
  if (!is_new) bytes_ -= cost(fragment);
  fragment.offset = packet.offset;
  if (!waiting.unwanted) fragment.data = {packet.data, packet.data + packet.size};
  bytes_ += cost(fragment);
}

void Reassembly::drop_data(Waiting& waiting) {
  waiting.unwanted = true;
  for (auto& [number, fragment] : waiting.fragments) {
    bytes_ -= fragment.data.size();
    fragment.data = {};
  }
}

/// Each fragment must begin where the one before it ends.
std::optional<BusMessage> Reassembly::join(const Waiting& whole) const {
  if (whole.unwanted) return std::nullopt;
  BusMessage message{whole.channel, {}};
  message.bytes.reserve(whole.message_size);
  for (const auto& [number, fragment] : whole.fragments) {
    if (fragment.offset != message.bytes.size()) break;
    message.bytes.insert(message.bytes.end(), fragment.data.begin(), fragment.data.end());
  }
  if (message.bytes.size() == whole.message_size) return message;
  on_refusal(Refusal::contradiction);
  return std::nullopt;
}

Reassembly::Waiting Reassembly::remove(Place place) {
  Waiting removed = std::move(*place);
  for (const auto& [number, fragment] : removed.fragments) bytes_ -= cost(fragment);
  waiting_.erase(place);
  return removed;
}

void Reassembly::give_up(Place place, Refusal why) {
  if (!remove(place).unwanted) on_refusal(why);
}

std::size_t Reassembly::cost(const Fragment& fragment) {
  constexpr std::size_t node = 128;  // bytes of the map's node and of both allocations, about
  return fragment.data.size() + node;
}

}  // namespace lcmslam::udpm
