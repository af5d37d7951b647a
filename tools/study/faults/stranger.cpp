#include "tools/study/faults/stranger.hpp"

#include <algorithm>

namespace lcmslam {
namespace {

// All of our types begin with utime, seq and sender.
constexpr std::size_t fingerprint_end = 8, sender_begin = 24, sender_end = 32;

}  // namespace

void Stranger::keep(const std::string& channel, std::vector<std::uint8_t> bytes) {
  Kept& kept = kept_[channel];
  if (kept.heard++ % 100 == 0 && bytes.size() < 60'000) kept.bytes = std::move(bytes);
}

void Stranger::send(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  if (!bytes.empty()) lcm_.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
}

void Stranger::pretend() {
  for (const auto& [channel, kept] : kept_) {
    std::vector<std::uint8_t> bytes = kept.bytes;
    if (bytes.size() < sender_end) continue;
    for (std::size_t i = sender_begin; i < sender_end; ++i) bytes[i] = static_cast<std::uint8_t>(17 + i);
    send(channel, bytes);
  }
}

void Stranger::babble() {
  for (const auto& [channel, kept] : kept_) {
    std::vector<std::uint8_t> bytes = kept.bytes;
    if (bytes.size() <= fingerprint_end) continue;
    for (int i = 0; i < 5; ++i) {
      const auto at =
          fingerprint_end +
          static_cast<std::size_t>(random_.uniform() * static_cast<double>(bytes.size() - fingerprint_end));
      bytes[std::min(at, bytes.size() - 1)] = static_cast<std::uint8_t>(256 * random_.uniform());
    }
    send(channel, bytes);
  }
}

}  // namespace lcmslam
