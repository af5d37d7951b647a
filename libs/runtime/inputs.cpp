#include "runtime/inputs.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>

namespace lcmslam {

void InputCount::follow(std::int64_t seq, std::int64_t known_missing) {
  if (seq < 0) return;  // a foreign sender that does not number
  if (last_seq < 0 || seq > last_seq) {
    if (last_seq >= 0) lost += std::max<std::int64_t>(0, seq - last_seq - 1 - known_missing);
    last_seq = seq;
  } else if (seq == last_seq) {
    ++duplicates;
  } else {
    ++reordered;  // was counted as lost when its successor came
    if (lost > 0) --lost;
  }
}

void Input::deliver(const std::uint8_t* data, std::size_t size, std::int64_t dropped) {
  known_missing_ += dropped;
  counted_ = false;
  try {
    decode_and_handle(data, size);
  } catch (const std::exception& error) {  // nothing that comes from the bus may end the process
    last_error = error.what();
    ++decode_errors;
    // The 1st, 2nd, 4th, 8th ...: a flood of garbage must not flood the log.
    if ((decode_errors & (decode_errors - 1)) == 0)
      spdlog::warn("{}: {} ({} so far)", channel_, error.what(), decode_errors);
    if (!counted_) ++known_missing_;
  }
}

void Input::seen(const Origin& origin, Utime utime, std::size_t size) {
  constexpr Utime far_away =
      100'000'000'000'000'000;  // us, 3000 years: differences of sound times never overflow
  if (utime < -far_away || utime > far_away)
    throw DecodeError("utime " + std::to_string(utime) + " is no time");
  constexpr std::size_t most_senders = 64;  // garbage must not grow the table for ever
  const bool known = senders.count(origin.sender) > 0;
  InputCount& count = senders[known || senders.size() < most_senders ? origin.sender : 0];
  ++count.received;
  count.bytes += static_cast<std::int64_t>(size);
  count.last_utime = utime;
  count.follow(origin.seq, known_missing_);
  known_missing_ = 0;
  counted_ = true;
  if (on_seen) on_seen(utime);
}

bool Inputs::deliver(const std::string& channel, const std::uint8_t* data, std::size_t size) {
  bool found = false;
  for (const auto& input : inputs_) {
    if (input->channel() != channel) continue;
    input->deliver(data, size);
    found = true;
  }
  return found;
}

}  // namespace lcmslam
