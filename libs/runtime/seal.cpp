#include <lcmslam/runtime/seal.hpp>

#include <sodium.h>
#include <algorithm>

#include <lcmslam/log/seal_trailer.hpp>

namespace lcmslam {
namespace {

using Hash = std::array<std::uint8_t, seal::hash_size>;

constexpr std::int64_t longest_way = 30'000'000;  // us
constexpr std::size_t most_remembered = 4096;     // before old ones are looked for

std::int64_t microseconds_of(WallTime time) {
  return std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count();
}

void append_number(std::vector<std::uint8_t>& bytes, std::int64_t number) {
  for (int shift = 56; shift >= 0; shift -= 8)
    bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(number) >> shift));
}

std::int64_t number_at(const std::uint8_t* bytes) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < seal::number_size; ++i) number = number << 8 | bytes[i];
  return static_cast<std::int64_t>(number);
}

/// Over the channel with its end, so that "AB" + "C" is not "A" + "BC", and all that stands before the hash.
Hash hash_of(const BusKey& key, const std::string& channel, const std::uint8_t* data, std::size_t size) {
  Hash hash{};
  crypto_generichash_state state;
  crypto_generichash_init(&state, key.data(), key.size(), hash.size());
  crypto_generichash_update(&state, reinterpret_cast<const std::uint8_t*>(channel.c_str()),
                            channel.size() + 1);
  crypto_generichash_update(&state, data, size);
  crypto_generichash_final(&state, hash.data(), hash.size());
  return hash;
}

}  // namespace

void Sealer::seal(const std::string& channel, std::vector<std::uint8_t>& message, WallTime now) {
  const std::int64_t time = microseconds_of(now);
  if (time < last_ - longest_way / 2) {  // the clock was set back: times of before are too late for anyone
    randombytes_buf(&sender_, sizeof sender_);
    last_ = 0;
  }
  last_ = std::max(last_ + 1, time);
  message.insert(message.end(), seal::mark.begin(), seal::mark.end());
  append_number(message, sender_);
  append_number(message, last_);
  const Hash hash = hash_of(key_, channel, message.data(), message.size());
  message.insert(message.end(), hash.begin(), hash.end());
}

std::optional<Refusal> SealChecker::open(BusMessage& message, WallTime now) {
  const std::size_t size = seal::size_within(message.bytes.data(), message.bytes.size());
  if (size == message.bytes.size()) return Refusal::unsealed;
  const std::uint8_t* trailer = message.bytes.data() + size;
  const std::size_t before_hash = message.bytes.size() - seal::hash_size;
  const Hash hash = hash_of(key_, message.channel, message.bytes.data(), before_hash);
  if (sodium_memcmp(hash.data(), message.bytes.data() + before_hash, hash.size()) != 0)
    return Refusal::unsealed;

  const std::int64_t sender = number_at(trailer + seal::mark_size);
  const std::int64_t time = number_at(trailer + seal::mark_size + seal::number_size);
  const std::int64_t oldest = microseconds_of(now) - longest_way;
  if (time < oldest || time > oldest + 2 * longest_way) {
    last_age_ = 1e-6 * (static_cast<double>(microseconds_of(now)) - static_cast<double>(time));
    return Refusal::other_time;
  }
  if (last_.size() >= most_remembered)
    for (auto it = last_.begin(); it != last_.end();)
      it = it->second < oldest ? last_.erase(it) : std::next(it);
  std::int64_t& last = last_[{sender, message.channel}];
  if (time <= last) return Refusal::replayed;
  last = time;
  message.bytes.resize(size);
  return std::nullopt;
}

}  // namespace lcmslam
