#include "tools/log/lcm_play_bus.hpp"

#include <algorithm>
#include <stdexcept>

#include <lcmslam/messages/decode.hpp>
#include <lcmslam/runtime/buffered_reader.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include <lcmslam/status_t.hpp>
#include "tools/log/message_facts.hpp"

namespace lcmslam {

LcmPlayBus::LcmPlayBus(const std::string& lcm_url, const std::set<std::string>& answer_channels)
    : bus_(lcm_url),
      sender_(bus_.lcm(), draw_sender(), largest_whole_message(lcm_url)),
      answer_channels_(answer_channels) {
  if (!bus_.usable()) throw std::runtime_error("LCM cannot use " + lcm_url + "; `lcmslam doctor` tells why");
  std::set<std::string> channels = answer_channels;
  channels.insert("STATUS");
  // While it waits for the time of the next message the socket must be emptied.
  reader_ = std::make_unique<BufferedReader>(bus_.listen(ChannelSet(channels)));
}

void LcmPlayBus::send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) {
  sender_.send(channel, bytes, utime);
}

void LcmPlayBus::wait_until(Time time) {
  using std::chrono::milliseconds;
  const auto left = std::chrono::ceil<milliseconds>(time - now());
  const auto wait = std::clamp(left, milliseconds(0), milliseconds(100));  // stop requests are seen in time
  BusMessage message;
  if (!reader_->read(message, wait)) return;
  if (message.channel == "STATUS") receive_status(message);
  const auto utime = message_utime(message.bytes.data(), message.bytes.size());
  if (answer_channels_.count(message.channel) > 0 && utime && on_answer) on_answer(message.channel, *utime);
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

void LcmPlayBus::receive_status(const BusMessage& message) {
  try {
    const auto status = decode_message<status_t>(message.bytes.data(), message.bytes.size());
    if (status.state == status_t::RUNNING)
      running_.insert(status.process);
    else
      running_.erase(status.process);
    if (status.state == status_t::STARTING || status.state == status_t::RUNNING)
      present_.insert(status.process);
    else
      present_.erase(status.process);
  } catch (const DecodeError&) {  // somebody else's STATUS
  }
}

}  // namespace lcmslam
