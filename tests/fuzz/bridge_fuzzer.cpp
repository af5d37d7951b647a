// Any sequence of publications from a broker: for each a byte of choices, a byte that says how long the topic
// is, two for the payload's size, topic and payload. Nothing but sound messages of allowed channels passes.

#include <algorithm>
#include <cstdlib>

#include <lcmslam/messages/any_message.hpp>
#include "procs/bridge/incoming.hpp"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcmslam;
  static const bridge::Topics topics("lcmslam", "dora", bridge::Side::robot);
  Incoming robot(bridge::parse_rules({"COMMAND", "MAP_REQUEST@5"}), bridge::Side::robot);
  Incoming other(bridge::parse_rules({"COMMAND", "ICP_KEYFRAME", "CAMERA"}), bridge::Side::operating);
  Incoming::Time now(std::chrono::seconds(1000));
  std::int64_t offered = 0, passed = 0;
  while (size >= 4) {
    const bool kept = (data[0] & 1) != 0, to_robot = (data[0] & 2) != 0, any_topic = (data[0] & 4) != 0;
    const std::size_t topic_size = std::min<std::size_t>(data[1], size - 4);
    const std::size_t announced = static_cast<std::size_t>(data[2]) << 8 | data[3];
    std::string topic(reinterpret_cast<const char*>(data + 4), topic_size);
    data += 4 + topic_size;
    size -= 4 + topic_size;
    const std::vector<std::uint8_t> payload(data, data + std::min(announced, size));
    data += payload.size();
    size -= payload.size();
    if (!any_topic) topic = "lcmslam/dora/to/" + topic;
    const std::string channel = topics.channel_of(topic);
    if (channel.empty()) continue;
    now += std::chrono::milliseconds(data[-1]);
    ++offered;
    Incoming& incoming = to_robot ? robot : other;
    std::vector<Incoming::Message> messages = incoming.due(now);
    if (auto message = incoming.take(channel, payload.data(), payload.size(), kept, now)) {
      require(!to_robot || !kept);
      messages.push_back(std::move(*message));
    }
    for (const Incoming::Message& message : messages) {
      ++passed;
      require(message.channel == "COMMAND" || message.channel == "MAP_REQUEST" ||
              message.channel == "ICP_KEYFRAME" || message.channel == "CAMERA");
      require(identify(message.bytes.data(), message.bytes.size()).utime == message.utime);
    }
  }
  require(passed + robot.refused() + other.refused() <= offered);
  return 0;
}
