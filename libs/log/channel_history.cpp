#include <lcmslam/log/channel_history.hpp>

#include <cstring>

namespace lcmslam {
namespace {

std::uint64_t first_bytes(const std::uint8_t* data, std::size_t size) {
  std::uint64_t value = 0;
  std::memcpy(&value, data, std::min<std::size_t>(size, sizeof value));
  return value;
}

}  // namespace

void ChannelHistory::add(const LogEventView& event) {
  constexpr std::size_t most_channels = 10'000;  // more are garbage
  auto found = kinds_.find(event.channel);
  if (found == kinds_.end()) {
    if (kinds_.size() == most_channels) return;
    found = kinds_.emplace(std::string(event.channel), Kind{}).first;
  }
  Kind& kind = found->second;
  kind.of_this_size = kind.size == event.size ? kind.of_this_size + 1 : 1;
  kind.size = event.size;
  kind.fingerprint = first_bytes(event.data, event.size);
}

bool ChannelHistory::resembles(std::string_view channel, const std::uint8_t* data, std::size_t size) const {
  constexpr std::int64_t enough = 3;  // messages of one size make a rule
  const auto found = kinds_.find(channel);
  if (found == kinds_.end() || found->second.fingerprint != first_bytes(data, size)) return false;
  return found->second.of_this_size < enough || found->second.size == size;
}

}  // namespace lcmslam
