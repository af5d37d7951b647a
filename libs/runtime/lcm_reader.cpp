#include <lcmslam/runtime/lcm_reader.hpp>

#include <cerrno>
#include <stdexcept>

namespace lcmslam {
namespace {

// LCM's queue throws the newest away without a word: long enough for the pauses of a busy machine.
constexpr int queue_capacity = 20'000;  // messages

}  // namespace

LcmReader::LcmReader(lcm::LCM& lcm, const ChannelSet& channels) : lcm_(lcm.getUnderlyingLCM()) {
  for (const std::string& pattern : channels.patterns()) {
    lcm_subscription_t* subscription = lcm_subscribe(lcm_, pattern.c_str(), &LcmReader::receive, this);
    if (subscription == nullptr) {
      unsubscribe();
      throw std::runtime_error("LCM cannot subscribe to " + pattern);
    }
    lcm_subscription_set_queue_capacity(subscription, queue_capacity);
    subscriptions_.push_back(subscription);
  }
}

LcmReader::~LcmReader() {
  unsubscribe();
}

void LcmReader::unsubscribe() {
  for (lcm_subscription_t* subscription : subscriptions_) lcm_unsubscribe(lcm_, subscription);
}

void LcmReader::receive(const lcm_recv_buf_t* buffer, const char* channel, void* self) {
  const auto* data = static_cast<const std::uint8_t*>(buffer->data);
  static_cast<LcmReader*>(self)->waiting_.push_back({channel, {data, data + buffer->data_size}});
}

bool LcmReader::read(BusMessage& message, std::chrono::milliseconds wait) {
  if (waiting_.empty() && lcm_handle_timeout(lcm_, static_cast<int>(wait.count())) < 0 && errno != EINTR)
    throw std::runtime_error("LCM stopped receiving");
  if (waiting_.empty()) return false;
  message = std::move(waiting_.front());
  waiting_.pop_front();
  return true;
}

}  // namespace lcmslam
