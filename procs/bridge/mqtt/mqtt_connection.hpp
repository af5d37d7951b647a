#pragma once
// One connection to a broker, from its attempt to its end, over libmosquitto. Used by one thread.

#include <functional>
#include <map>
#include <memory>
#include <string>

#include <lcmslam/bridge/broker.hpp>

struct mosquitto;

namespace lcmslam {

class MqttConnection {
 public:
  struct Events {
    std::function<void()> connected;
    std::function<void(int message)> acknowledged;
    std::function<void(const std::string& filter, const std::string& why)> unsubscribed;  // it was refused
    std::function<void(const std::string& topic, const std::uint8_t* data, std::size_t size, bool kept)> came;
  };
  /// Begins to connect. `presence`: the topic that the broker sets to "0" when this connection falls silent;
  /// empty: none. Throws std::runtime_error.
  MqttConnection(const bridge::Broker& broker, const std::string& presence, Events events);
  ~MqttConnection();
  MqttConnection(const MqttConnection&) = delete;
  MqttConnection& operator=(const MqttConnection&) = delete;

  /// Sends and receives, up to the time, and calls the events. Throws std::runtime_error when the connection
  /// has ended, with its reason.
  void loop(std::chrono::milliseconds wait);

  /// All below throw std::runtime_error when the connection has ended. `lives`: s, 0: for ever. Gives the
  /// message's number, which `acknowledged` will name.
  int publish(const std::string& topic, const void* data, std::size_t size, bool kept, double lives);
  /// What comes from now on, and if `with_kept` what the broker has kept.
  void subscribe(const std::string& filter, bool with_kept);
  void disconnect();
  std::int64_t refused() const { return refused_; }  ///< publications that the broker did not take

 private:
  struct Callbacks;
  void check(int result, const char* what) const;

  Events events_;
  std::unique_ptr<mosquitto, void (*)(mosquitto*)> client_;
  std::string ended_;  // why; empty: it has not
  std::int64_t refused_ = 0;
  std::map<int, std::string> asked_;  // filters that the broker has not answered for, by message
};

}  // namespace lcmslam
