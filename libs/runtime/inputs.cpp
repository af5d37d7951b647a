#include <lcmslam/runtime/inputs.hpp>

#include <spdlog/spdlog.h>

#include <lcmslam/messages/print_message.hpp>

namespace lcmslam {
namespace {

/// What is wrong with a message may repeat its texts, which are anybody's bytes, and goes out in each STATUS.
std::string told(const std::exception& error) {
  constexpr std::size_t longest = 200;  // bytes
  return printable(std::string(error.what()).substr(0, longest));
}

}  // namespace

void Input::deliver(const std::uint8_t* data, std::size_t size, std::int64_t dropped) {
  known_missing_ += dropped;
  counted_in_ = nullptr;
  try {
    decode_and_handle(data, size);
  } catch (const std::exception& error) {  // nothing that comes from the bus may end the process
    last_error = told(error);
    ++decode_errors;
    // The 1st, 2nd, 4th, 8th ...: a flood of garbage must not flood the log.
    if ((decode_errors & (decode_errors - 1)) == 0)
      spdlog::warn("{}: {} ({} so far)", channel_, last_error, decode_errors);
    if (counted_in_ == nullptr)
      ++known_missing_;
    else
      --counted_in_->received;  // nothing is counted twice
  }
}

void Input::seen(const Origin& origin, Utime utime, std::size_t size) {
  constexpr Utime far_away =
      100'000'000'000'000'000;  // us, 3000 years: differences of sound times never overflow
  if (utime < -far_away || utime > far_away)
    throw DecodeError("utime " + std::to_string(utime) + " is no time");
  InputCount& count = senders.of(origin.sender);
  ++count.received;
  count.bytes += static_cast<std::int64_t>(size);
  count.last_utime = utime;
  count.follow(origin.seq, known_missing_, utime);
  known_missing_ = 0;
  counted_in_ = &count;
  if (on_seen) on_seen(utime);
}

void Input::skip(const MessageIdentity& message) {
  senders.of(message.origin.sender).follow(message.origin.seq, known_missing_, message.utime);
  known_missing_ = 0;
}

std::optional<MessageIdentity> Inputs::BytesInput::identify(const std::uint8_t* data,
                                                            std::size_t size) const {
  try {
    const AnyMessage message = lcmslam::identify(data, size);
    return MessageIdentity{message.origin, message.utime};
  } catch (const DecodeError&) {
    return std::nullopt;
  }
}

void Inputs::BytesInput::decode_and_handle(const std::uint8_t* data, std::size_t size) {
  const AnyMessage message = lcmslam::identify(data, size);
  seen(message.origin, message.utime, size);
  handler_({data, data + size}, message);
}

Input& Inputs::subscribe_bytes(const std::string& channel, std::size_t capacity, BytesHandler handler) {
  inputs_.push_back(std::make_unique<BytesInput>(channel, capacity, std::move(handler)));
  return *inputs_.back();
}

std::int64_t Inputs::refused() const {
  std::int64_t sum = stamps_.refused() + stamps_.foreign();
  for (const auto& input : inputs_) sum += input->decode_errors;
  return sum;
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

bool Inputs::admit(const std::string& channel, std::int64_t sender, Utime utime) {
  const StampVerdict verdict = stamps_.judge(channel, sender, utime);
  if (verdict == StampVerdict::new_session) {
    spdlog::info("{}: time began anew: a new session", channel);
    if (on_new_session) on_new_session();
  }
  return verdict == StampVerdict::take || verdict == StampVerdict::new_session;
}

}  // namespace lcmslam
