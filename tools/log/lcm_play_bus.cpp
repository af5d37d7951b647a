#include "tools/log/lcm_play_bus.hpp"

#include <algorithm>
#include <cerrno>
#include <stdexcept>

#include <lcmslam/messages/decode.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include <lcmslam/status_t.hpp>
#include "tools/log/message_facts.hpp"

namespace lcmslam {

LcmPlayBus::LcmPlayBus(const std::string& lcm_url, const std::set<std::string>& answer_channels)
    : lcm_(lcm_url), sender_(lcm_, draw_sender(), largest_whole_message(lcm_url)) {
  if (!is_usable(lcm_))
    throw std::runtime_error("LCM cannot use " + lcm_url + "; `lcmslam doctor` tells why");
  lcm_.subscribe("STATUS", &LcmPlayBus::receive_status, this)->setQueueCapacity(1000);
  for (const auto& channel : answer_channels)
    lcm_.subscribe(channel, &LcmPlayBus::receive_answer, this)->setQueueCapacity(1000);
}

void LcmPlayBus::send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) {
  sender_.send(channel, bytes, utime);
}

void LcmPlayBus::wait_until(Time time) {
  using std::chrono::milliseconds;
  const auto left = std::chrono::ceil<milliseconds>(time - now());
  const auto wait = std::clamp(left, milliseconds(0), milliseconds(100));  // stop requests are seen in time
  if (lcm_.handleTimeout(static_cast<int>(wait.count())) < 0 && errno != EINTR && !stopped())
    throw std::runtime_error("LCM stopped receiving");
}

bool LcmPlayBus::stopped() {
  return stop_requested();
}

bool LcmPlayBus::wait_for(const std::set<std::string>& processes, Time until) {
  const auto all_run = [&] {
    return std::includes(running_.begin(), running_.end(), processes.begin(), processes.end());
  };
  while (!all_run() && now() < until && !stopped()) wait_until(until);
  return all_run();
}

void LcmPlayBus::receive_status(const lcm::ReceiveBuffer* buffer, const std::string&) {
  try {
    const auto status =
        decode_message<status_t>(static_cast<const std::uint8_t*>(buffer->data), buffer->data_size);
    if (status.state == status_t::RUNNING)
      running_.insert(status.process);
    else
      running_.erase(status.process);
  } catch (const DecodeError&) {  // somebody else's STATUS
  }
}

void LcmPlayBus::receive_answer(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
  const auto utime = message_utime(static_cast<const std::uint8_t*>(buffer->data), buffer->data_size);
  if (utime && on_answer) on_answer(channel, *utime);
}

}  // namespace lcmslam
