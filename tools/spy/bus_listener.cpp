#include "tools/spy/bus_listener.hpp"

#include <stdexcept>

namespace lcmslam {
namespace {

ChannelSet channels_matching(const std::string& pattern) {
  try {
    return ChannelSet::matching(pattern);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(error.what());
  }
}

}  // namespace

BusListener::BusListener(const std::string& lcm_url, const std::string& pattern, Handler handler)
    : bus_(lcm_url), handler_(std::move(handler)) {
  if (!bus_.usable()) throw std::runtime_error(lcm_url + " cannot be used; ./lcmslam doctor says why");
  reader_ = std::make_unique<BufferedReader>(bus_.listen(channels_matching(pattern)));
}

bool BusListener::handle(std::chrono::milliseconds wait) {
  BusMessage message;
  try {
    if (!reader_->read(message, wait)) return false;
  } catch (const std::runtime_error&) {
    return false;  // a provider that reconnects
  }
  handler_(message.channel, message.bytes.data(), message.bytes.size());
  return true;
}

void BusListener::run(const std::function<bool()>& stop) {
  constexpr std::chrono::milliseconds period{50}, taking{20};
  while (!stop()) handle(period);
  // The reader's thread may still be taking what has come from the socket.
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  while (handle(taking) && std::chrono::steady_clock::now() < end) {
  }
}

}  // namespace lcmslam
