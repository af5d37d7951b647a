#pragma once
// Keeps a connection to the broker, in a thread of its own: connects, again and again with growing pauses,
// sends what the outbox gives and hands over what comes.

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "procs/bridge/bridge_node.hpp"
#include "procs/bridge/mqtt/mqtt_connection.hpp"

namespace lcmslam {

class MqttLink : public bridge::BrokerLink {
 public:
  explicit MqttLink(BridgeEnds ends);
  /// Says good-bye to the broker.
  ~MqttLink() override;

  std::string state() const override;

 private:
  using Clock = std::chrono::steady_clock;
  class Session;

  void run();
  void say(const std::string& state);

  BridgeEnds ends_;
  const std::string run_;  // marks this bridge's numbers among those of others
  mutable std::mutex mutex_;
  std::condition_variable stopped_;
  std::string state_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace lcmslam
