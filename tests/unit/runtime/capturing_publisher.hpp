#pragma once
// Keeps what a node publishes, as bytes.

#include <string>
#include <vector>

#include <lcmslam/runtime/publisher.hpp>

namespace lcmslam::testing {

struct Published {
  std::string channel;
  std::vector<std::uint8_t> bytes;
  Utime utime = 0;
  bool operator==(const Published& other) const {
    return channel == other.channel && bytes == other.bytes && utime == other.utime;
  }
};

class CapturingPublisher : public Publisher {
 public:
  explicit CapturingPublisher(std::int64_t sender = 1234) : Publisher(sender) {}

  std::vector<Published> all;

  template <class M>
  std::vector<M> on(const std::string& channel) const {
    std::vector<M> messages;
    for (const Published& p : all)
      if (p.channel == channel) messages.push_back(decode_message<M>(p.bytes.data(), p.bytes.size()));
    return messages;
  }

 private:
  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) override {
    all.push_back({channel, bytes, utime});
  }
};

}  // namespace lcmslam::testing
