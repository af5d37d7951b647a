#include "tools/spy/bus_listener.hpp"

#include <chrono>
#include <stdexcept>
#include <thread>

#include <lcmslam/runtime/lcm_bus.hpp>

namespace lcmslam {
namespace {

// LCM's queue throws the newest away without a word: long enough for the pauses of a busy machine.
constexpr int queue_capacity = 20'000;  // messages

}  // namespace

BusListener::BusListener(const std::string& lcm_url, const std::string& pattern, Handler handler)
    : lcm_(lcm_url), handler_(std::move(handler)) {
  if (!is_usable(lcm_)) throw std::runtime_error(lcm_url + " cannot be used; ./lcmslam doctor says why");
  // Through C: the C++ wrapper does not say when the pattern is none.
  const auto receive = [](const lcm_recv_buf_t* buffer, const char* channel, void* self) {
    static_cast<BusListener*>(self)->handler_(channel, static_cast<const std::uint8_t*>(buffer->data),
                                              buffer->data_size);
  };
  lcm_subscription_t* subscription = lcm_subscribe(lcm_.getUnderlyingLCM(), pattern.c_str(), receive, this);
  if (subscription == nullptr) throw std::runtime_error(pattern + " is no regular expression of channels");
  lcm_subscription_set_queue_capacity(subscription, queue_capacity);
}

void BusListener::run(const std::function<bool()>& stop) {
  while (!stop())
    if (lcm_.handleTimeout(50) < 0) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  // LCM's own thread may still be taking what has come from the socket.
  using Clock = std::chrono::steady_clock;
  const auto stopped = Clock::now();
  while (Clock::now() < stopped + std::chrono::milliseconds(20)) lcm_.handleTimeout(5);
  while (lcm_.handleTimeout(0) > 0 && Clock::now() < stopped + std::chrono::seconds(1)) {
  }
}

}  // namespace lcmslam
